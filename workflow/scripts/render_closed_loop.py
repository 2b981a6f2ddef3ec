"""Render a part of the label sets as linear power and reduce it to what the statistics need."""

from job import job, progress

from lib.diagnostics.closed_loop import as_frame, thinned
from snowsim.io.files import read_dataset, write_dataset
from snowsim.io.scenes import SceneSet
from snowsim.phy import draw_parameters, plan, render_plan
from snowsim.seeding import random_stream
from snowsim.statistics import merge, summarise, summary_to_dataset


def render_power(scene, statistics, tolerance_db, speckle_correlation, normalise, align, width, rng):
    # As many looks as the flight, so that 20 lines average as many here as there.
    drawn = {"width": width, "speckle_correlation": speckle_correlation}
    parameters = draw_parameters(statistics, scene.layer_bins.shape[0], **drawn, rng=rng)
    options = {"tolerance_db": tolerance_db, "speckle": "gamma", "normalise": normalise, "align": align}
    return render_plan(plan(scene.layer_bins, parameters, scene.n_range_bins, **options), rng=rng)


def summarise_part(
    paths_to_layers, statistics, convention, seed, tolerance_db, speckle_correlation, first, span, stride
):
    """Sums over renders of label scenes `span`, of files whose first scene is number `first`."""
    geometry = {name: statistics.attrs[name] for name in ("bin_size_s", "line_spacing_m")}
    _, *conventions = convention.split("_")
    summaries = []
    with SceneSet(paths_to_layers) as scenes:
        for index in progress(range(*span), "closed loop"):
            scene = scenes[index - first]
            # By scene, never by part; where no width is drawn, the same speckle for every convention.
            rng = random_stream(seed, "closed_loop", scene.name)
            power = render_power(scene, statistics, tolerance_db, speckle_correlation, *conventions, rng)
            frame = as_frame(power, scene.layer_bins, index, **geometry)
            summaries.append(thinned(summarise(*frame, where=scene.name), stride))
    return merge(summaries)


def render_part(paths_to_layers, path_to_statistics, path_to_summary, **options):
    summary = summarise_part(paths_to_layers, read_dataset(path_to_statistics), **options)
    dataset = summary_to_dataset(summary)
    write_dataset(path_to_summary, dataset.assign_attrs(synthetic="renders by PHY, not observed data"))


if __name__ == "__main__":
    with job(snakemake):
        render_part(snakemake.input.layers, snakemake.input.statistics, snakemake.output.summary, **snakemake.params)
