"""Figure of the label sets."""

from itertools import islice

from main_path import job

from evaluation.lib.figures.labels import labels
from evaluation.lib.figures.style import Scale, save_figure
from snowsim.io.files import read_dataset
from snowsim.io.scenes import SceneSet

with job(snakemake):
    params = snakemake.params
    statistics = read_dataset(snakemake.input.statistics)
    scale = Scale.of(statistics, params.snow_density_kg_m3)
    with SceneSet(snakemake.input.labels) as scenes:
        figure = labels(list(islice(scenes, params.n_scenes)), statistics, scale)
    save_figure(snakemake.output.labels_svg, figure, params.source)
