"""Label models with other zones and spectra beside the one that labels use: AIC and BIC."""

from functools import partial

import pandas as pd
from main_path import logger, run

from evaluation.lib.label_models import choose, compare_models, tabulate_models, tabulate_spectra
from evaluation.lib.machine import device_name, time_rounds
from evaluation.lib.spectra import with_spectra
from snowsim.io.files import read_dataset, write_table
from snowsim.labels import draw_scene, prepare
from snowsim.seeding import random_stream
from snowsim.statistics import merge, summary_from_dataset
from snowsim.statistics.zones import zone_models

N_ZONES = 4
TIMED_SCENES = 30
TIMED_ROUNDS = 5


def compare_label_models(
    summaries,
    statistics,
    selection,
    scenes,
    spectra,
    seconds,
    *,
    seed,
    zone_counts,
    n_range_lines,
    n_scenes,
):
    flight = read_dataset(statistics)
    summary = merge(summary_from_dataset(read_dataset(path)) for path in summaries)
    tapered = flight.attrs["estimator"] != "paper"
    models = zone_models(summary, flight.sizes["layer"], zone_counts, tapered=tapered)
    surface = flight[[name for name in flight.data_vars if name.startswith("surface_")]]
    by_count = {
        count: model.merge(surface) for count, model in zip(zone_counts, models, strict=True)
    }
    found = tabulate_models(list(by_count.values()))
    chosen = {
        "paper": (N_ZONES, "tabulated"),
        "aic": choose(found, "aic", "aic"),
        "bic": choose(found, "bic", "bic"),
        "bic, 4 zones": choose(found, N_ZONES, "bic"),
    }
    logger.info("chosen: %s", chosen)
    prepared = {}
    for name, (n_zones, psd) in chosen.items():
        dataset = with_spectra(by_count[n_zones], psd)
        prepared[name] = prepare(dataset, n_range_lines, radiometry="constant")
    stream = partial(random_stream, seed, "compare_label_models")

    def draw_scenes(model):
        rng = stream()
        for scene in range(TIMED_SCENES):
            draw_scene(model, n_range_lines, name=f"{scene}", rng=rng)

    works = {name: partial(draw_scenes, model) for name, model in prepared.items()}
    runs = pd.DataFrame(time_rounds(works, TIMED_ROUNDS), columns=["model", "repeat", "seconds"])
    compared = {name: (*chosen[name], model) for name, model in prepared.items()}
    write_table(selection, found)
    write_table(scenes, compare_models(compared, found, n_scenes, stream))
    write_table(spectra, tabulate_spectra(flight["thickness_psd"].values[:, 0]))
    write_table(seconds, runs.assign(n_scenes=TIMED_SCENES, device=device_name()))


run(compare_label_models)
