"""Frames of the synthetic flight written as foreign files with the traps of their formats, for runs on "own" data."""

import formats
import numpy as np

LINE_S = 0.05
BEFORE_MIDNIGHT_S = 86_390
SURFACE_ID, NO_PICKS_ID = 60, 3


def content_of(echogram, first_line):
    """Echogram dataset as `formats` takes it; range lines follow each other over frames."""
    n_lines = echogram.sizes["slow_time"]
    along = {
        name: echogram[name].values for name in ("Latitude", "Longitude", "Elevation", "Surface")
    }
    return {
        "Data": echogram["Data"].transpose("twtt", "slow_time").values,
        "Time": echogram["twtt"].values,
        "GPS_time": formats.GPS_START
        + BEFORE_MIDNIGHT_S
        + LINE_S * (first_line + np.arange(n_lines)),
        **along,
        **dict.fromkeys(("Roll", "Pitch", "Heading"), np.zeros(n_lines)),
    }


def layer_names(n_layers):
    """Names of layers from the surface down."""
    return ["surface", *[f"Koenig_{number + 1}" for number in range(1, n_layers)]]


def write_layers(folder, name, layers, content, *, old=False):
    """Layer file beside its organizer; ids do not tell the order, and one layer has no pick."""
    twtt = layers["twtt"].transpose("layer", "slow_time").values
    names = layer_names(len(twtt))
    path = folder / f"Data_{name}.mat"
    if old:
        values = formats.old_layer_content(twtt, content["GPS_time"], names)
        formats.write_mat5(path, values | {"Elevation": content["Elevation"]})
        return path
    twtt = np.vstack([twtt, np.full((1, twtt.shape[1]), np.nan)])[::-1]
    ids = [NO_PICKS_ID, *(SURFACE_ID - np.arange(len(names)))[::-1]]
    formats.write_mat5(
        path, formats.layer_content(twtt, ids, content["GPS_time"], elevation=content["Elevation"])
    )
    # One organizer for all frames of a segment.
    organizer = formats.organizer_content(
        [*(SURFACE_ID - np.arange(40)), NO_PICKS_ID], [*layer_names(40), "Koenig_99"]
    )
    formats.write_mat5(folder / f"layer_{name.rpartition('_')[0]}.mat", organizer)
    return path


def write_echogram(folder, name, content, kind):
    """One echogram file: "nsidc" crosses midnight and is compensated, "mat5" has rows, "mat73" is compensated."""
    n_bins, n_lines = content["Data"].shape
    # Range bins a compressed file inserted above each line: steps of a slow climb.
    correction = (np.arange(n_lines) // 64) % 7
    made = formats.compensated(content, correction, n_kept=n_bins + correction.max())
    if kind == "nsidc":
        seconds = content["GPS_time"] - formats.GPS_START
        if (
            seconds[0] < 86_400
        ):  # seconds of day fall back at midnight; a frame begun after it counts on
            seconds %= 86_400
        extra = {"Elevation_Correction": made.pop("Elevation_Correction")}
        made.pop("Truncate_Bins")
        formats.write_nsidc(folder / name, made, seconds=seconds, extra=extra)
    elif kind == "mat5":
        formats.write_mat5(folder / name, content | {"Time": content["Time"][None]})
    else:
        attitude = ("Roll", "Pitch", "Heading")
        formats.write_mat73(
            folder / name, {key: value for key, value in made.items() if key not in attitude}
        )
    return folder / name
