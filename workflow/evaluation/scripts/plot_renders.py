"""Figure of both renders of observed and of synthetic layers."""

from itertools import islice

from main_path import job

from evaluation.lib.figures import renders
from evaluation.lib.figures.style import METHODS, Scale, save_figure
from snowsim.io.files import read_dataset
from snowsim.io.scenes import SceneSet

with job(snakemake):
    files = snakemake.input
    params = snakemake.params
    test = {"observed": SceneSet(files.observed)}
    drawn = {}
    for method in METHODS:
        test[method] = SceneSet(files[f"{method}_test"])
        drawn[method] = list(islice(SceneSet(files[f"{method}_labels"]), params.n_labels))
    scale = Scale.of(read_dataset(files.statistics), params.snow_density_kg_m3)
    save_figure(snakemake.output.sample_svg, renders.sample(test, drawn, scale), params.source)
