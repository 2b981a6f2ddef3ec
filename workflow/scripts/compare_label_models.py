"""Label models with other zones and spectra: what criteria say of them, what they save, and the one asked for."""

import pandas as pd
from job import job, logger

from lib.diagnostics.label_models import choose, compare_models, tabulate_criteria, tabulate_families
from lib.timing import device_name, time_rounds
from snowsim.io.files import read_dataset, write_dataset, write_table
from snowsim.labels import draw_scene, prepare
from snowsim.labels.models import label_model
from snowsim.seeding import random_stream
from snowsim.statistics import merge, summary_from_dataset
from snowsim.statistics.zones import zone_models

PAPER = (4, "tabulated")
TIMED_SCENES, TIMED_ROUNDS = 30, 5


def chosen_models(criteria, n_zones, psd):
    """What each model is, by what chose it."""
    return {
        "paper": PAPER,
        "aic": choose(criteria, "aic", "aic"),
        "bic": choose(criteria, "bic", "bic"),
        "bic, 4 zones": choose(criteria, PAPER[0], "bic"),
        "in use": choose(criteria, n_zones, psd),
    }


def time_models(models, n_range_lines, stream):
    """Seconds to draw some scenes from each model, every repeat."""

    def work(model):
        rng = stream()
        for scene in range(TIMED_SCENES):
            draw_scene(model, n_range_lines, name=f"{scene}", rng=rng)

    works = {name: lambda model=model: work(model) for name, (_, _, model) in models.items()}
    runs = pd.DataFrame(time_rounds(works, TIMED_ROUNDS), columns=["model", "repeat", "seconds"])
    return runs.assign(n_scenes=TIMED_SCENES, device=device_name())


def compare(paths_to_summaries, path_to_statistics, paths, seed, n_zones, psd, zone_counts, n_range_lines, n_scenes):
    statistics = read_dataset(path_to_statistics)
    summary = merge(summary_from_dataset(read_dataset(path)) for path in paths_to_summaries)
    by_count = dict(zip(zone_counts, zone_models(summary, statistics.sizes["layer"], zone_counts), strict=True))
    criteria = tabulate_criteria(list(by_count.values()))
    chosen = chosen_models(criteria, n_zones, psd)
    logger.info("chosen: %s", chosen)
    datasets = {name: label_model(by_count[zones], psd) for name, (zones, psd) in chosen.items()}
    models = {name: (*chosen[name], prepare(dataset, n_range_lines)) for name, dataset in datasets.items()}

    def stream():
        return random_stream(seed, "compare_label_models")

    write_dataset(paths["model"], datasets["in use"].assign_attrs(synthetic=statistics.attrs["synthetic"]))
    write_table(paths["criteria"], criteria)
    write_table(paths["savings"], compare_models(models, criteria, n_scenes, stream))
    write_table(paths["spectra"], tabulate_families(statistics["thickness_psd"].values[:, 0]))
    write_table(paths["seconds"], time_models(models, n_range_lines, stream))


if __name__ == "__main__":
    with job(snakemake):
        compare(
            snakemake.input.summaries,
            snakemake.input.statistics,
            dict(snakemake.output.items()),
            **snakemake.params,
        )
