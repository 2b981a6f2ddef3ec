"""A flight as a table of frames: each row names an echogram, its layers and its role."""

import hashlib
import io
import os
import warnings
from pathlib import Path

import numpy as np
import pandas as pd

from snowsim.alignment import (
    FLAGGED,
    FLAGGED_BY,
    bin_size_s,
    count_flagged,
    cut_blocks,
    join,
)
from snowsim.constants import BLOCK_LINES
from snowsim.echogram import check_choice, check_layers, named_frame
from snowsim.io import read_echogram, read_layers
from snowsim.io.containers import SUPPLEMENT_FLAGS
from snowsim.io.files import library_errors, one_line, refusal, report
from snowsim.io.layers import VALUES_WITHOUT_PICK, as_named, begins_with_surface
from snowsim.io.pairs import PLAIN_NAME, SCENE_NAME
from snowsim.io.times import leap_seconds
from snowsim.progress import with_progress

FRAME_COLUMNS = ("frame", "echogram", "layers", "role")
# A frame to track needs no layers. Its echogram may have another role in another row.
TRACK = "track"
ROLES = ("statistics", "train", "validation", "test", TRACK)
HELD_OUT = ("test", "validation")
# Layers have the clock of their echogram if this share of its range lines has a line of the layers
# within SAME_TIME.
LEAST_SHARE_OF_LINES = 0.99
SAME_TIME = np.timedelta64(1, "ms")


def read_frames(path):
    """Table of frames, checked without opening the files that it names.

    Tab-separated text with a header: `frame` (a name), `echogram` and `layers` (files, relative to
    the table's folder; made absolute), `role` ("statistics", "train", "validation", "test", or
    "track", which needs no layers). Lines that begin with # are comments. An echogram held out
    ("test", "validation") may have no other role except "track". One ValueError lists all rows that
    fail, one a line.
    """
    path = Path(path)
    with library_errors(path, "table: expected tab-separated text"):
        lines = path.read_text(encoding="utf-8").splitlines()
        text = "\n".join(line for line in lines if not line.startswith("#"))
        table = pd.read_csv(io.StringIO(text), sep="\t", dtype=str, keep_default_na=False)
        table = table.rename(columns=str.strip)
    is_ragged = not isinstance(table.index, pd.RangeIndex)
    if is_ragged or sorted(table.columns) != sorted(FRAME_COLUMNS) or table.empty:
        expected = f"{', '.join(FRAME_COLUMNS)}, and rows of as many fields"
        found = f"{', '.join(map(str, table.columns))}, and {len(table)} rows"
        raise refusal(path, "columns", expected, f"{found}, longer ones" if is_ragged else found)
    table = table[list(FRAME_COLUMNS)].apply(lambda column: column.str.strip())
    for name in ("echogram", "layers"):
        files = table[name]
        table[name] = [os.path.abspath(path.parent / file) if file else "" for file in files]
    failed = _troubles(table)
    report(failed, f"{path}: {len(failed)} of {len(table)} frames fail")
    return table


def _troubles(table):
    """Messages of rows that fail, one a row, with the first reason."""
    real = table["echogram"].map(os.path.realpath)
    # Tracking a frame does not use its data for training or scores.
    role = table["role"].mask(table["role"] == TRACK)
    n_roles = role.groupby(real).transform("nunique")
    is_held_out = role.isin(HELD_OUT).groupby(real).transform("any")
    twice = pd.DataFrame({"file": real, "role": role}).duplicated(keep=False)
    once = f"expected once for a role, and for {' or '.join(HELD_OUT)} alone, found"
    is_bad = ~table["frame"].str.fullmatch(SCENE_NAME.pattern)
    # A file or a directory: a Zarr store is a directory.
    absent = ~table[["echogram", "layers"]].map(os.path.exists)
    checks = [
        ("frame", "expected names that differ, found", table["frame"].duplicated(keep=False)),
        ("frame", f"expected {PLAIN_NAME}, found", is_bad & role.notna()),
        ("role", f"expected {', '.join(ROLES)}, found", ~table["role"].isin(ROLES)),
        ("echogram", "expected a file, found nothing at", absent["echogram"]),
        ("layers", "expected a file, found nothing at", absent["layers"] & role.notna()),
        ("echogram", once, (twice | (is_held_out & (n_roles > 1))) & role.notna()),
    ]
    failed = {}
    for column, words, fails in checks:
        for number, row in table[fails].iterrows():
            name = row["frame"] or f"row {number + 1}"
            failed.setdefault(number, f"{name}: {column}: {words} {row[column] or 'none'}")
    return [failed[number] for number in sorted(failed)]


def check_frames(table, *, bin_s=None, blocks=False, **options):
    """Table of all frames, except those to track, with sizes and counts; each is read once.

    One ValueError names all frames that fail. `bin_s` and `options` are those of `read_frame`;
    without `bin_s`, all frames must have the same bin size. With `blocks`, all frames but those of
    role "statistics" are cut into scenes too, and a frame without a scene fails. Columns added:

    - `n_range_lines`, `n_range_bins`, `n_layers`, `bin_size_s` of the frame;
    - `n_scenes`, `n_skipped` (blocks that are no scenes) and `n_flagged_blocks` (skipped blocks
      with a flagged line);
    - `n_flagged_lines`, and `flags` (text: number of range lines by flag).

    A held-out frame ("test", "validation") whose power is that of another row, as of a copy, fails,
    and so does a copy of a frame of the same role.
    Without `layer_names`, a warning is given where frames have layers of other names at one place.
    """
    table = table[table["role"] != TRACK]
    rows = []
    failed = []
    layer_names = options.get("layer_names") or ()
    missing = set(layer_names)
    powers = {}
    names_of = {}
    for row in with_progress(table.itertuples(), len(table), unit="frame"):
        try:
            echogram, layers = read_frame(row, bin_s=bin_s, **options)
            rows.append(_summary(row, echogram, layers, blocks=blocks))
            _refuse_copy(row, echogram, powers)
            names_of[row.frame] = layers.get_index("layer")
            missing -= set(layers["layer"].values[layers["twtt"].notnull().any("slow_time")])
        except ValueError as error:
            failed.append(f"{row.frame}: {error}")
    found = pd.DataFrame(rows or {"frame": [], "bin_size_s": []})
    usual_s = found["bin_size_s"].median()
    for row in found[(found["bin_size_s"] / usual_s - 1).abs() > 1e-6].itertuples():
        expected = f"bin size: expected {usual_s:.6g} s as in most"
        failed.append(f"{row.frame}: {expected}, found {row.bin_size_s:.6g} s")
    if not failed:
        reason = "layer_names: expected layers that some frame has, found it in none"
        failed = [f"{name}: {reason}" for name in layer_names if name in missing]
        report(failed, f"frames: {len(failed)} of {len(layer_names)} layer_names are in no frame")
    report(failed, f"frames: {len(failed)} of {len(table)} frames fail")
    if not layer_names:
        _warn_of_names(names_of)
    return table.merge(found, on="frame", validate="one_to_one")


def _refuse_copy(row, echogram, powers):
    """Refuse a row whose power is that of another file of its role, or of one that is held out.

    `powers` has the rows before by the digest of their power, and is added to.
    """
    power = np.ascontiguousarray(echogram["Data"].values)
    first = powers.setdefault(hashlib.sha256(power).hexdigest(), row)
    refused = row.role == first.role or {row.role, first.role} & set(HELD_OUT)
    if refused and os.path.realpath(first.echogram) != os.path.realpath(row.echogram):
        expected = f"power unlike that of {first.frame}, of the same role or one that is held out"
        raise refusal(row.echogram, "Data", expected, f"a copy of {first.echogram}")


def _warn_of_names(names_of):
    """Warn if layers at one place have other names in other frames, named (frame, layer)."""
    firsts = {}
    for frame, names in names_of.items():
        for place, name in enumerate(names if names.dtype.kind in "OUS" else ()):
            first = firsts.setdefault(place, (name, frame))
            if first[0] != name:
                text = (
                    f"layer {place} is {first[0]} in {first[1]} and {name} in {frame}: statistics "
                    "take both for one layer, unless layer_names (import.layer_names) lists names"
                )
                warnings.warn(text, stacklevel=3)
                return


def _summary(row, echogram, layers, *, blocks):
    """Values of one frame in the columns of `check_frames`."""
    cuts_blocks = blocks and row.role != "statistics"
    scenes, skipped = scenes_of_frame(row, echogram, layers) if cuts_blocks else ([], {})
    n_flagged_lines, flags = count_flagged(echogram)
    return {
        "frame": row.frame,
        "n_range_lines": echogram.sizes["slow_time"],
        "n_range_bins": echogram.sizes["twtt"],
        "n_layers": layers.sizes["layer"],
        "bin_size_s": bin_size_s(echogram),
        "n_scenes": len(scenes),
        "n_skipped": len(skipped),
        "n_flagged_blocks": sum(reason.endswith(FLAGGED) for reason in skipped.values()),
        "n_flagged_lines": n_flagged_lines,
        "flags": flags,
    }


def scenes_of_frame(row, echogram, layers):
    """Scenes of a frame, and reasons for its skipped blocks; ValueError if it has no scene."""
    scenes, skipped = cut_blocks(echogram, layers, name=row.frame)
    if not scenes:
        reasons = "; ".join(f"{name}: {reason}" for name, reason in skipped.items())
        reasons = reasons or f"a block has {BLOCK_LINES}"
        found = f"none in {echogram.sizes['slow_time']} range lines ({one_line(reasons, 200)})"
        raise refusal(row.echogram, "blocks", "at least one that is a scene", found)
    return scenes, skipped


def read_frame(
    row,
    *,
    bin_s=None,
    flattening="surface",
    layer_names=None,
    flagged_by=FLAGGED_BY,
    source=None,
):
    """Echogram and layers of one row of the table, joined for statistics and blocks.

    `row` has the attributes `echogram` and `layers`, as rows of `table.itertuples()` have. The
    echogram is resampled to range bins of `bin_s` [s], by default its own, and levelled by
    `flattening` ("surface", "elevation", "none": see `snowsim.alignment.flatten`). `layer_names`
    lists layers from the surface down; layer i is then the same one in all frames, NaN in a frame
    without it. By default all layers with picks are taken. `flagged_by` names flags of the
    supplement; range lines with one of these lose their power and picks. `source` is the format
    that the echogram must have ("nsidc", "cresis", "opr"); by default any.

    Echogram and layers come on the same range lines, with the snow surface as layer 0, and with
    `flagged (slow_time)` where the echogram has flags. ValueError if a file is damaged; if layers
    do not cover the echogram, leave its window, cross or include no surface; if all range lines are
    flagged; or if a flag is unknown.
    """
    for flag in flagged_by:
        check_choice("flagged_by", flag, SUPPLEMENT_FLAGS)
    echogram = read_echogram(row.echogram, source=source)
    layers = _layers_from_surface(row.layers, layer_names)
    _check_clock(row.layers, layers, echogram)
    _compare_segments(row, layers, echogram)
    return join(
        echogram,
        layers,
        echogram_name=row.echogram,
        layers_name=row.layers,
        flagged_by=flagged_by,
        bin_s=bin_s,
        flattening=flattening,
    )


def _compare_segments(row, layers, echogram):
    """Warn if layers are of another segment than the echogram, by their names."""
    files = (row.echogram, echogram), (row.layers, layers)
    told = [named_frame(str(each.attrs.get("granule", path)))[0] for path, each in files]
    if None not in told and told[0] != told[1]:
        msg = f"{row.layers}: layers are of segment {told[1]}, the echogram is of {told[0]}"
        warnings.warn(msg, UserWarning, stacklevel=3)


def _layers_from_surface(path, layer_names):
    """Layers of a file from the surface down: all, or those of `layer_names`, NaN if missing."""
    layers = read_layers(path, names=layer_names, missing="skip")
    if layer_names is not None:
        absent = {"twtt": np.nan, **VALUES_WITHOUT_PICK}
        held = layers["layer"].values.astype(str)
        wanted = [as_named(name, held) for name in layer_names]
        layers = layers.reindex(layer=wanted, fill_value=absent)
        if wanted != list(layer_names):
            layers = layers.assign_coords(layer=list(layer_names))
        check_layers(layers, f"{path}: in the order of layer_names")
    if not begins_with_surface(layers):
        expected = "one named surface (from the organizer file beside it), the first"
        labels = layers["layer"].values.astype(str)
        raise refusal(path, "layer", expected, one_line(", ".join(labels), 200))
    return layers


def _check_clock(path, layers, echogram):
    """Raise ValueError if the layers fit the echogram only after a shift by leap seconds."""
    ours, theirs = (pd.Index(each["slow_time"].values) for each in (echogram, layers))
    late_s = leap_seconds(ours.values[0])
    reach = np.median(np.diff(theirs)) if theirs.size > 1 else SAME_TIME
    for tolerance in (SAME_TIME, reach):
        share = {}
        for shift_s in (0, late_s, -late_s):
            shifted = theirs + np.timedelta64(shift_s, "s")
            nearest = shifted.get_indexer(ours, method="nearest", tolerance=tolerance)
            share[shift_s] = (nearest >= 0).mean()
        shift_s = max(share, key=share.get)
        if share[0] < LEAST_SHARE_OF_LINES <= share[shift_s]:
            order = "later" if shift_s < 0 else "earlier"
            found = f"times {abs(shift_s)} s {order} than its own: is one of both GPS time?"
            raise refusal(path, "slow_time", "UTC as in the echogram", found)
