"""Scenes of the synthetic benchmark: 8-bit images from tracks parallel to the sample flight's."""

from reference.echo import draw_stretch
from reference.line import line_length_km
from reference.picks import pick_peaks, visible_layers
from snowsim.echogram import (
    ROWS_BELOW_LAST_LAYER,
    SURFACE_ROW,
    Scene,
    check_choice,
    scene_height,
    to_uint8,
)
from snowsim.limits import check_values

SPLITS = ("train", "validation", "test")
SLOTS = 160  # places for scenes on one track
# Share of a track's scenes in the part of the line where firn percolates; the flight has fewer.
PERCOLATION_SHARE = 0.12
PERCOLATION_START = 0.95  # where that part begins, as a share of the line
# Coprime to SLOTS and near its golden section, so that any number of scenes spreads over the line.
STRIDE = 61
SPARE_KM = 1.0  # end of the line that is left free


def scene_position(index, split, length_km):
    """Track and start [km] of a scene on a line of `length_km`.

    No two scenes overlap, nor does one overlap the sample flight: each split (`train`,
    `validation`, `test`) has tracks of its own, parallel to the flight's, with `SLOTS` places each.
    """
    track, place = divmod(index, SLOTS)
    slot = (place * STRIDE + SLOTS // 4) % SLOTS
    n_dry = round(SLOTS * (1 - PERCOLATION_SHARE))
    if slot < n_dry:
        fraction = slot / n_dry * PERCOLATION_START
    else:
        beyond = (slot - n_dry) / (SLOTS - n_dry)
        fraction = PERCOLATION_START + beyond * (1 - PERCOLATION_START)
    return f"{split}_{track}", fraction * (length_km - SPARE_KM)


def draw_scene(index, split, *, climate, settings, n_looks, n_range_lines=256, rng):
    """Draw one `Scene` of the benchmark; `rng` is for this scene alone.

    Its complete layers are all autumn horizons down to where they fade, that is, where their
    expected rise over the snow above them falls below `visible_db`, see `n_visible_layers`. Scenes
    of `train` have as `layer_bins` what a semi-automatic picker found on the image, others the
    complete layers. The surface lies near row 50; the image ends 100 rows below the deepest layer
    and has at least 300 rows. ValueError if the split is unknown or a scene would not fit its
    place.
    """
    check_choice("split", split, SPLITS)
    radar = settings.radar
    length_km = n_range_lines * radar.line_spacing_m / 1e3
    track, start_km = scene_position(index, split, line_length_km())
    percolation_km = (1 - PERCOLATION_START) * (line_length_km() - SPARE_KM)
    room_km = percolation_km / round(SLOTS * PERCOLATION_SHARE)
    what = f"kilometres of {n_range_lines} range lines"
    check_values(what, length_km, 0, room_km, above=True)
    n_rows = SURFACE_ROW + radar.n_range_bins - radar.surface_bin
    stretch = draw_stretch(
        climate, settings, track, start_km, n_range_lines, SURFACE_ROW, n_rows, rng=rng
    )
    truth = visible_layers(stretch.echo.mean(), stretch.layer_bins(), settings.picks.visible_db)
    truth = truth[truth.max(axis=1) < n_rows - ROWS_BELOW_LAST_LAYER - 1]
    height = scene_height(truth)
    power = stretch.echo.cropped(height).draw(n_looks, rng=rng)
    image, noise_floor_db, maximum_db = to_uint8(power)
    layer_bins = truth
    if split == "train":
        layer_bins = pick_peaks(power, truth, settings.picks, rng=rng)
    column = stretch.column
    return Scene(
        f"{split}_{index:04d}",
        height,
        layer_bins,
        image=image,
        complete_layer_bins=truth,
        noise_floor_db=noise_floor_db,
        maximum_db=maximum_db,
        notes={
            "track": track,
            "start_km": start_km,
            "accumulation_m": column.place.accumulation_m,
            "n_looks": n_looks,
            "percolation": column.percolation,
            "fade_depth_m": column.fade_depth_m,
        },
    )
