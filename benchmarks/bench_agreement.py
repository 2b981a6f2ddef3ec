# ruff: noqa: E402
"""Agreement of two passes over the same snow beside F against its truth, by flight.

``python benchmarks/bench_agreement.py TABLE.csv [N_SCENES [FLIGHT ...]]`` draws two passes over the
places of the test scenes of the flights of `studies.transfer` (40 scenes each): the same firn, with
another speckle and from another height. The package's tracker picks the layers of each pass.
TABLE.csv has a row for each flight, and below them the rank correlation (Spearman) over the flights
of every figure of agreement with F. A pick is right within 2 of the tracker's range bins.
"""

import sys
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import yaml
from scipy.stats import spearmanr

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "workflow")]

from lib.configuration import filled
from pretrained.transfer import reference_of
from reference import checked_settings, draw_climate
from reference.benchmark import scene_position
from reference.column import draw_column
from reference.echo import Stretch, draw_echo
from reference.line import SECONDS_PER_KM, line_coordinates, line_length_km
from reference.picks import visible_layers
from reference.radar import draw_surface_row
from snowsim import Tracker, agreement
from snowsim.alignment import layer_bins_of
from snowsim.constants import SPEED_OF_LIGHT_M_S
from snowsim.echogram import SURFACE_ROW
from snowsim.io import echogram, write_table
from snowsim.metrics.picks import layer_rows
from snowsim.progress import with_progress
from snowsim.seeding import random_stream
from snowsim.snowpack import agreement_summary

N_LINES = 256
HIGHER = 1.8  # height of the second pass over that of the first
WITHIN_BINS = 2.0  # of the tracker, of a pick that is right
WITHIN_M = 25.0  # an overlap is compared in every 500 m
TAKE_OFF = np.datetime64("2012-04-29T12:00:00", "ns")
FIGURES = ("share_matched", "depth_rms_m", "accumulation_rms_m_we", "share_same_year", "offset")


def passes(settings, climate, n_looks, index, seed):
    """Two passes over a scene's place: pairs of an echogram and its true layers in range bins."""
    radar = settings.radar
    track, start_km = scene_position(index, "test", line_length_km())
    position_km = start_km + np.arange(N_LINES) * radar.line_spacing_m / 1e3
    n_below = radar.n_range_bins - radar.surface_bin
    rng = random_stream(seed, "bench_agreement", index)
    column = draw_column(climate, track, position_km, n_below, rng=rng)
    latitude, longitude = line_coordinates(position_km)
    nanoseconds = np.rint(position_km * SECONDS_PER_KM * 1e9).astype("timedelta64[ns]")
    for number, times_as_high in enumerate((1, HIGHER)):
        flown = replace(radar, height_m=times_as_high * radar.height_m)
        rng = random_stream(seed, "bench_agreement", index, number)
        surface_row = draw_surface_row(N_LINES, SURFACE_ROW, flown, rng=rng)
        n_rows = SURFACE_ROW + n_below
        echo = draw_echo(column, surface_row, n_rows, settings.firn, flown, rng=rng)
        stretch = Stretch(position_km, surface_row, column, echo)
        truth = visible_layers(echo.mean(), stretch.layer_bins(), settings.picks.visible_db)
        first_s = 2 * flown.height_m / SPEED_OF_LIGHT_M_S - SURFACE_ROW * radar.bin_size_s
        drawn = echogram(
            echo.draw(n_looks, rng=rng),
            twtt=first_s + radar.bin_size_s * np.arange(n_rows),
            slow_time=TAKE_OFF + nanoseconds,
            Latitude=latitude,
            Longitude=longitude,
            Elevation=np.full(N_LINES, column.place.elevation_m + flown.height_m),
            Surface=first_s + radar.bin_size_s * surface_row,
        )
        yield drawn, truth


def compared(tracker, flight, config, n_scenes):
    """Row of a flight: F of all picks below the surface, and figures of agreement of its passes."""
    settings = checked_settings(reference_of(flight, config["reference"]))
    climate = draw_climate(settings, rng=random_stream(flight["seed"], "climate"))
    n_looks = flight.get("n_looks", config["benchmark"]["n_looks"])
    within_bins = WITHIN_BINS * tracker.card.bin_s / settings.radar.bin_size_s
    segments = {}
    counts = np.zeros(3)  # right picks, picks, true pixels
    for index in with_progress(range(n_scenes), unit="scene"):
        both = passes(settings, climate, n_looks, index, flight["seed"])
        for number, (drawn, truth) in enumerate(both):
            layers = tracker.pick(drawn)
            segments[f"{index}_{number}"] = layers.assign(
                drawn[["Latitude", "Longitude", "Elevation"]]
            )
            picked = layer_bins_of(layers, drawn)
            rows = layer_rows(picked, truth, within_bins=within_bins)
            below = rows[rows["layer"] > 0]
            n_picked = np.isfinite(picked[1:]).sum()
            counts += [below["n_within"].sum(), n_picked, below["n_true"].sum()]
    whole = agreement_summary(agreement(segments, within_m=WITHIN_M)).iloc[-1]
    return {
        "flight": flight["name"],
        "n_scenes": n_scenes,
        "f": 2 * counts[0] / counts[1:].sum(),
        **whole[["n_places", "n_compared", *FIGURES[:-1]]],
        "offset": whole["n_offset"] / whole["n_compared"],  # share of places
    }


def main(path, n_scenes=40, *names):
    """Draw, track, compare and write."""
    config = filled(yaml.safe_load((ROOT / "config/config.yaml").read_text()))
    tracker = Tracker.from_pretrained()
    flights = config["studies"]["transfer"]["flights"]
    rows = []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # of doubtful dates, which are not scored here
        for flight in flights:
            if not names or flight["name"] in names:
                rows.append(compared(tracker, flight, config, int(n_scenes)))
    table = pd.DataFrame(rows)
    if len(table) > 2:
        ranks = {name: spearmanr(table[name], table["f"]).statistic for name in FIGURES}
        table.loc[len(table)] = {"flight": "rank correlation with f", **ranks}
    write_table(path, table)
    print(table.round(3).to_string(index=False))  # noqa: T201


if __name__ == "__main__":
    main(*sys.argv[1:])
