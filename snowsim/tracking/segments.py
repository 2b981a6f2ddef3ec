"""Tracks one segment: its frames are read one by one, linked, and written together."""

import hashlib
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from snowsim.echogram import from_uint8
from snowsim.io import echogram, read_echogram
from snowsim.io.files import image_format_of, library_errors, noted, refusal, written_together
from snowsim.io.layers import (
    TOGETHER,
    join_frames,
    numbers_in_names,
    refuse_existing,
    refuse_other_frames,
    rounded,
    with_frame,
    write_layer_files,
    write_layers,
)
from snowsim.io.pairs import BLURRED, read_image
from snowsim.io.pictures import write_picture
from snowsim.tracking.trackers import layer_names

# A frame follows another if it begins within this time after the end of the other, or within the
# time of this many range lines, whichever is longer.
PAUSE_S = 2.0
PAUSE_LINES = 5
# Limits of the decibels that the greys of an image span where it does not say. Within them, the
# span makes its darkest row the noise floor.
CONTRASTS_DB = (20.0, 100.0)
EDGE_ROWS = 24  # rows of a picture above its layers, and below them


@dataclass(frozen=True)
class Output:
    """Where and how layers are written: arguments of `track_files`."""

    folder: Path
    png: bool
    bin_s: float | None
    force: bool


@dataclass(frozen=True, eq=False)
class _Frame:
    """A file and the candidates for layers that were detected in it.

    `gap` is the note that says why this frame is not linked with the one before, else None.
    """

    path: Path
    segment: str | None
    number: int | None
    evidence: object
    notes: tuple
    gap: str | None = None


def track_segment(tracker, files, output, say, advance):
    """Track the `File` of a segment, or one image, and write its layers; the number that failed.

    `say` is called with one line for each note, error and file written, `advance` after each file,
    with the number of its range lines.
    """
    try:
        _refuse_outputs(files, output)
    except (ValueError, OSError) as error:
        say(f"error: {error}")
        for _ in files:
            advance(0)
        return len(files)
    frames = []
    for file in files:
        try:
            frame = _load_and_detect(tracker, file, output.bin_s)
        except (ValueError, OSError) as error:
            say(f"error: {error}")
            advance(0)
            continue
        for note in frame.notes:
            say(f"{file.path}: {note}")
        frames.append(frame)
        advance(frame.evidence.slow_time.size)
    if not frames:
        return len(files)
    try:
        _link_and_write(tracker, frames, output, say)
    except (ValueError, OSError) as error:
        say(f"error: {error}")
        return len(files)
    return len(files) - len(frames)


def _refuse_outputs(files, output):
    """Refuse outputs that exist, and a folder that holds layer files of other frames."""
    folder = output.folder
    if files[0].segment is not None:
        refuse_other_frames(folder, files[0].segment, [file.number for file in files])
    outputs = [layers_file(folder, files[0])]
    outputs += [_picture_file(folder, file.path) for file in files if output.png]
    inputs = {file.path.resolve().parent for file in files}
    for path in outputs:
        if path.exists() and folder.resolve() in inputs:
            wanted = "none beside the input, also with force (give another folder)"
            raise refusal(path, "file", wanted, "one")
        if not output.force:
            refuse_existing(path)


def layers_file(folder, file):
    """File of the layers of a `File` and its whole segment, or of an image."""
    return folder / f"{file.segment or file.path.stem}_layers.nc"


def _picture_file(folder, path):
    """File of the picks drawn on the echogram of an input."""
    return folder / f"{path.stem}_picks.png"


def _load_and_detect(tracker, file, bin_s):
    """`_Frame` of a `File`."""
    path = file.path
    if file.segment is None:
        echogram = _image_as_echogram(path, bin_s)
        evidence = tracker.detect(echogram, str(path))
        notes = list(evidence.notes)
        if image_format_of(path) == "JPEG":
            notes.append(BLURRED)
        row_db = 10 * np.log10(echogram["Data"].values).mean(axis=1)
        if min(row_db[:EDGE_ROWS].mean(), row_db[-EDGE_ROWS:].mean()) > np.median(row_db):
            notes.append(
                "the picture is bright above and below: expected bright layers on a dark ground"
            )
    else:
        with noted(path) as told:
            echogram = read_echogram(path)
        evidence = tracker.detect(echogram, str(path))
        notes = [*told, *evidence.notes]
    return _Frame(path, file.segment, file.number, evidence, tuple(notes))


def _image_as_echogram(path, bin_s):
    """Echogram dataset of an 8-bit grey image with range bins of `bin_s` seconds."""
    if bin_s is None:
        raise refusal(path, "image", "--bin-s, the range bin of an image in seconds", "none")
    image, numbers = read_image(path)
    floor_db = numbers.get("noise_floor_db", 0.0)
    darkest = image.mean(axis=1).min()
    contrast_db = np.clip(10 * (255 / max(darkest, 1.0) - 1), *CONTRASTS_DB)
    power_db = from_uint8(image, floor_db, numbers.get("maximum_db", floor_db + contrast_db))
    power = (10 ** (power_db / 10)).astype(np.float32)
    twtt = bin_s * np.arange(len(power))
    return echogram(power, twtt=twtt, attrs={"source_format": "image"})


def _link_and_write(tracker, frames, output, say):
    """Link the frames of a segment, or of one image, and write their layers and pictures."""
    folder = output.folder
    segment = frames[0].segment
    path = layers_file(folder, frames[0])
    found, notes = _linked(tracker, frames, say)
    if segment is None:
        written = _with_rows(found[0], output.bin_s)
    else:
        attributes = {"day_seg": segment, TOGETHER: _digest(frames, tracker.card)}
        found = [layers.assign_attrs(attributes) for layers in found]
        parts, of_times = _one_after_another(found)
        for note in of_times:
            say(f"{path}: {note}")
        notes += of_times
        written = join_frames(parts)
    is_picked = written["twtt"].notnull().any("slow_time")
    is_picked[0] = True
    written = written.isel(layer=is_picked.values).assign_attrs(notes="; ".join(notes))
    with written_together():
        if segment is not None:
            by_number = {frame.number: layers for frame, layers in zip(frames, found, strict=True)}
            write_layer_files(folder, segment, by_number, force=output.force)
        write_layers(path, written, force=output.force)
    n_picks = int(written["twtt"][1:].notnull().sum())
    say(f"{path}: {written.sizes['layer'] - 1} layers below the surface, {n_picks} picks")
    # Last, so that a picture that cannot be drawn stops no file.
    for frame, layers in zip(frames, found, strict=True) if output.png else ():
        _draw_picks(frame.path, layers, folder, output.bin_s)


def _linked(tracker, frames, say):
    """Layers of the frames of a segment, rounded, a list of datasets; and notes on them."""
    found = []
    notes = []
    for run in _runs(frames):
        if run[0].gap is not None:
            say(f"{run[0].path}: {run[0].gap}")
        layers_of_run = tracker.pick_together([frame.evidence for frame in run])
        for frame, layers in zip(run, _renumbered(layers_of_run, found), strict=True):
            of_frame = [*frame.notes, *([frame.gap] if frame.gap else [])]
            notes += [f"{frame.path.stem}: {note}" for note in of_frame]
            found.append(rounded(with_frame(layers, frame.path.stem)))
    return found, notes


def _runs(frames):
    """Frames of a segment that follow one another without a gap, list of lists.

    A new run begins where a frame is missing. It also begins where a frame is too early or too late
    or has another averaging; that frame then has a `gap`.
    """
    runs = []
    for frame in frames:
        last = runs[-1][-1] if runs else None
        if last is None or frame.number != last.number + 1:
            runs.append([frame])
            continue
        reason = _why_apart(last, frame)
        if reason is None:
            runs[-1].append(frame)
        else:
            gap = f"not linked with frame {last.number}: {reason}"
            runs.append([replace(frame, gap=gap)])
    return runs


def _why_apart(last, frame):
    """Reason not to link a frame with the last one before it, or None."""
    before, after = last.evidence, frame.evidence
    pause_s = (after.slow_time[0] - before.slow_time[-1]) / np.timedelta64(1, "s")
    lines_s = PAUSE_LINES * max(_interval_s(before.slow_time), _interval_s(after.slow_time))
    longest_s = max(PAUSE_S, lines_s)
    if pause_s <= 0:
        return f"it begins {-pause_s:.3g} s before that ends"
    if pause_s > longest_s:
        return f"it begins {pause_s:.3g} s after that ends, more than {longest_s:.3g} s"
    if after.n_averaged == before.n_averaged:
        return None
    return f"of its range lines {after.n_averaged} are averaged, of that {before.n_averaged}"


def _interval_s(slow_time):
    """Median time between range lines [s], 0 for a single range line."""
    steps = np.diff(slow_time) / np.timedelta64(1, "s")
    return float(np.median(steps)) if steps.size else 0.0


def _digest(frames, card):
    """Digest of the frames whose layers have common names, in order, and of the tracker's card."""
    digest = hashlib.sha256(repr(card).encode())
    for frame in frames:
        digest.update(frame.evidence.slow_time.tobytes())
        digest.update(frame.evidence.canonical.surface_db.tobytes())
    return digest.hexdigest()[:16]


def _renumbered(layers_of_run, before):
    """Layers of a run, numbered after those of the runs before it; all share the surface."""
    n_above = max((int(numbers_in_names(layers).max()) for layers in before), default=0)
    return [
        layers.assign_coords(layer=layer_names(numbers_in_names(layers) + n_above))
        for layers in layers_of_run
    ]


def _one_after_another(found):
    """Layers of frames in order of time, without range lines before the end of another frame.

    Also a list of notes on these lines. Their layers have no common names with the other's.
    """
    parts = []
    notes = []
    for layers in sorted(found, key=lambda layers: layers["slow_time"].values[0]):
        if parts:
            later = layers["slow_time"].values > parts[-1]["slow_time"].values[-1]
            if not later.all():
                names = [each["frame"].values[0] for each in (layers, parts[-1])]
                notes.append(
                    f"{names[0]}: {(~later).sum()} range lines before the end of {names[1]} are "
                    "left out here; the layer file of the frame has them"
                )
            layers = layers.isel(slow_time=later)
        if layers.sizes["slow_time"]:
            parts.append(layers)
    return parts, notes


def _with_rows(layers, bin_s):
    """Layers of an image with the rows of their picks."""
    rows = (layers["twtt"] / bin_s).assign_attrs(units="1", long_name="row of the image")
    layers = layers.assign(row=rows)
    layers["slow_time"].attrs["comment"] = "invented: a picture holds no times"
    return layers


def _draw_picks(path, layers, folder, bin_s):
    """Draw the picks of a file on its echogram.

    The file is read once more, because the samples of all frames of a segment do not fit into
    memory, and which samples are drawn depends on the picks.
    """
    picture = _picture_file(folder, path)
    with library_errors(picture, "picture: expected layers that can be drawn"):
        is_image = image_format_of(path) is not None
        with noted(path):  # as when it was tracked
            drawn_on = _image_as_echogram(path, bin_s) if is_image else read_echogram(path)
        write_picture(picture, layers, [drawn_on])
