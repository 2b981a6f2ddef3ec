"""Label models with other zones and spectra: AIC and BIC, parameters saved, and the one in use."""

from functools import partial

import pandas as pd
from job import logger, run

from lib.diagnostics.label_models import choose, compare_models, tabulate_models, tabulate_spectra
from lib.machine import device_name, time_rounds
from snowsim.io.files import read_dataset, write_dataset, write_table
from snowsim.labels import draw_scene, prepare
from snowsim.labels.models import label_model
from snowsim.labels.radiometry import NEEDED
from snowsim.seeding import random_stream
from snowsim.statistics import merge, summary_from_dataset
from snowsim.statistics.zones import zone_models

PAPER = (4, "tabulated")
TIMED_SCENES, TIMED_ROUNDS = 30, 5


def compare_label_models(
    summaries, statistics,
    model, selection, scenes, spectra, seconds, *, seed, n_zones, psd, zone_counts, n_range_lines, n_scenes,
):  # fmt: skip
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
        "paper": PAPER,
        "aic": choose(found, "aic", "aic"),
        "bic": choose(found, "bic", "bic"),
    }
    chosen |= {
        "bic, 4 zones": choose(found, PAPER[0], "bic"),
        "in use": choose(found, n_zones, psd),
    }
    logger.info("chosen: %s", chosen)
    datasets = {
        name: label_model(by_count[zones], spectrum) for name, (zones, spectrum) in chosen.items()
    }
    models = {
        name: (*chosen[name], prepare(dataset, n_range_lines)) for name, dataset in datasets.items()
    }
    stream = partial(random_stream, seed, "compare_label_models")

    def draw_scenes(prepared):
        rng = stream()
        for scene in range(TIMED_SCENES):
            draw_scene(prepared, n_range_lines, name=f"{scene}", rng=rng)

    works = {name: partial(draw_scenes, prepared) for name, (_, _, prepared) in models.items()}
    runs = pd.DataFrame(time_rounds(works, TIMED_ROUNDS), columns=["model", "repeat", "seconds"])
    drawn = datasets["in use"].assign({name: flight[name] for name in NEEDED if name in flight})
    write_dataset(model, drawn.assign_attrs(synthetic=flight.attrs["synthetic"]))
    write_table(selection, found)
    write_table(scenes, compare_models(models, found, n_scenes, stream))
    write_table(spectra, tabulate_spectra(flight["thickness_psd"].values[:, 0]))
    write_table(seconds, runs.assign(n_scenes=TIMED_SCENES, device=device_name()))


run(compare_label_models)
