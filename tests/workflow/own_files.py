"""Frames of the synthetic flight as foreign files with the traps of their formats: "own" data."""

import formats
import numpy as np

LINE_S = 0.05
BEFORE_MIDNIGHT_S = 86_390
SURFACE_ID, NO_PICKS_ID = 60, 3


def content_of(echogram, first_line):
    """Echogram dataset as `formats` takes it; range lines follow each other over frames."""
    line = first_line + np.arange(echogram.sizes["slow_time"])
    return formats.content_of(echogram, formats.GPS_START + BEFORE_MIDNIGHT_S + LINE_S * line)


def layer_names(n_layers):
    """Names of layers from the surface down."""
    return ["surface", *[f"Koenig_{number + 1}" for number in range(1, n_layers)]]


def write_layers(folder, name, layers, content):
    """Layer file beside its organizer; ids do not tell the order, and one layer has no pick."""
    twtt = layers["twtt"].transpose("layer", "slow_time").values
    names = layer_names(len(twtt))
    path = folder / f"Data_{name}.mat"
    no_picks = np.full((1, twtt.shape[1]), np.nan)
    twtt = np.vstack([twtt, no_picks])[::-1]
    ids_of_names = SURFACE_ID - np.arange(len(names))
    ids = [NO_PICKS_ID, *ids_of_names[::-1]]
    values = formats.layer_content(twtt, ids, content["GPS_time"], elevation=content["Elevation"])
    formats.write_mat5(path, values)
    # One organizer for all frames of a segment.
    segment = name.rpartition("_")[0]
    known_ids = [*(SURFACE_ID - np.arange(40)), NO_PICKS_ID]
    known_names = [*layer_names(40), "Koenig_99"]
    organizer = formats.organizer_content(known_ids, known_names)
    formats.write_mat5(folder / f"layer_{segment}.mat", organizer)
    return path


def write_echogram(folder, name, content):
    """One echogram file of NSIDC, elevation-compensated; the second frame crosses midnight."""
    n_bins, n_lines = content["Data"].shape
    # Range bins a compressed file inserted above each line: steps of a slow climb.
    correction = (np.arange(n_lines) // 64) % 7
    made = formats.compensated(content, correction, n_kept=n_bins + correction.max())
    seconds = content["GPS_time"] - formats.GPS_START
    # Seconds of day fall back at midnight; a frame begun after it counts on.
    if seconds[0] < 86_400:
        seconds %= 86_400
    formats.write_nsidc(folder / name, made, seconds=seconds)
    return folder / name
