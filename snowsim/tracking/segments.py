"""Tracks one segment: its frames are read one by one, linked, and written together."""

import json
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from snowsim.io import read_echogram
from snowsim.io.containers import open_container
from snowsim.io.echograms import content_and_digest, digest_or_unread
from snowsim.io.files import (
    noted,
    picture_format,
    read_dataset,
    refusal,
    written_together,
)
from snowsim.io.layers import (
    TOGETHER,
    digest_in,
    digest_of_inputs,
    join_frames,
    numbers_in_names,
    refuse_existing,
    refuse_other_frames,
    rounded,
    segment_files,
    with_frame,
    write_layer_files,
    write_layers,
)
from snowsim.io.pictures import draw_picks, pictures_of
from snowsim.tracking.trackers import layer_names
from snowsim.tracking.unfinished import Unfinished

NOT_DRAWN = ("twtt_low", "twtt_high", "confidence")
MOST_LOST = 20  # frames whose detection may be lost; those of longer segments are kept in files
# Attribute of a segment: frames that could not be tracked, and why, as JSON.
FAILED = "failed"

# A frame follows another if it begins within this time after the end of the other, or within the
# time of this many range lines, whichever is longer.
PAUSE_S = 2.0
PAUSE_LINES = 5
EDGE_ROWS = 24  # rows of a picture above its layers, and below them


@dataclass(frozen=True)
class Output:
    """Where and how layers are written: arguments of `track_files`."""

    folder: Path
    png: bool
    bin_s: float | None
    force: bool
    resume: bool

    @property
    def replaces(self):
        """Whether files are written over; with `resume` they were found to be this run's."""
        return self.force or self.resume


@dataclass(frozen=True, eq=False)
class _Frame:
    """A file and the candidates for layers that were detected in it.

    `gap` is the note that says why this frame is not linked with the one before, else None.
    """

    path: Path
    segment: str | None
    number: int | None
    digest: str
    evidence: object
    notes: tuple
    gap: str | None = None


def track_segment(tracker, files, output, say, advance):
    """Track the `File` of a segment, or one image, and write its layers; the number that failed.

    `say` is called with one line for each note, error and file written, `advance` after each file,
    with the number of its range lines.
    """
    try:
        left = _written_before(tracker.card, files, output) if output.resume else None
        if left is not None:
            for _ in files:
                advance(0)
            failed = json.loads(left.attrs.get(FAILED, "{}"))
            for message in failed.values():
                say(f"error: {message}")
            say(f"{layers_file(output.folder, files[0])}: it was written before")
            for file in files if output.png else ():
                if file.path.stem not in failed and not pictures_of(output.folder, file.path):
                    draw_picks(file.path, left, output.folder, output.bin_s)
            return len(failed)
        _refuse_outputs(files, output)
    except (ValueError, OSError) as error:
        say(f"error: {error}")
        for _ in files:
            advance(0)
        return len(files)
    unfinished = Unfinished(output.folder, tracker.card) if len(files) > MOST_LOST else None
    frames, digests, failed = _detected(tracker, files, output, unfinished, say, advance)
    if not frames:
        return len(files)
    attributes = {TOGETHER: digest_of_inputs(digests, tracker.card, output.bin_s)}
    if failed:
        attributes[FAILED] = json.dumps(failed)
    try:
        written = _link_and_write(tracker, frames, attributes, output, say)
        if unfinished is not None:
            unfinished.remove()
        # Last, so that a picture that cannot be drawn stops no file.
        for frame in frames if output.png else ():
            draw_picks(frame.path, written, output.folder, output.bin_s)
    except (ValueError, OSError) as error:
        say(f"error: {error}")
        return len(files)
    return len(failed)


def _detected(tracker, files, output, unfinished, say, advance):
    """List of `_Frame`, digests of all files, and the errors of those that failed, by name."""
    frames = []
    digests = []
    failed = {}
    for file in files:
        try:
            frame = _load_and_detect(tracker, file, output, unfinished)
        except (ValueError, OSError) as error:
            digests.append(digest_or_unread(file.path))
            failed[file.path.stem] = str(error)
            say(f"error: {error}")
            advance(0)
            continue
        for note in frame.notes:
            say(f"{file.path}: {note}")
        frames.append(frame)
        digests.append(frame.digest)
        advance(frame.evidence.slow_time.size)
    return frames, digests, failed


def _written_before(card, files, output):
    """Layers of a segment that was written whole, by the same tracker from the same inputs.

    None if there are none or not all files, or if one is damaged: such files are written anew.
    ValueError if they were made of other inputs or by another tracker, unless `output.force`.
    """
    path = layers_file(output.folder, files[0])
    segment = files[0].segment
    numbers = [file.number for file in files]
    *of_frames, organizer = segment_files(output.folder, segment, numbers) if segment else [path]
    there = [each for each in (*of_frames, path) if each.exists()]
    if not there:
        return None
    digests = [digest_or_unread(file.path) for file in files]
    together = digest_of_inputs(digests, card, output.bin_s)
    whole = set()
    for each in there:
        try:
            found = digest_in(each)
        except ValueError:
            continue
        if found == together:
            whole.add(each)
        elif not output.force:
            wanted = f"{together}, that of these inputs and this tracker, or --force (force=True)"
            raise refusal(each, TOGETHER, wanted, found)
    if path not in whole or not organizer.exists():
        return None
    layers = read_dataset(path)
    failed = json.loads(layers.attrs.get(FAILED, "{}"))
    needed = zip(files, of_frames, strict=True) if segment else ()
    is_whole = all(file.path.stem in failed or each in whole for file, each in needed)
    return layers.drop_vars(NOT_DRAWN) if is_whole else None


def _refuse_outputs(files, output):
    """Refuse outputs that exist, and a folder that holds layer files of other frames."""
    folder = output.folder
    outputs = [layers_file(folder, files[0])]
    outputs += [path for file in files if output.png for path in pictures_of(folder, file.path)]
    inputs = {file.path.resolve().parent for file in files}
    if files[0].segment is not None:
        refuse_other_frames(folder, files[0].segment, [file.number for file in files])
    for path in outputs:
        if path.exists() and folder.resolve() in inputs:
            wanted = "none beside the input, also with force (give another folder)"
            raise refusal(path, "file", wanted, "one")
        if not output.replaces:
            refuse_existing(path)


def layers_file(folder, file):
    """File of the layers of a `File` and its whole segment, or of an image."""
    return folder / f"{file.segment or file.path.stem}_layers.nc"


def _load_and_detect(tracker, file, output, unfinished):
    """`_Frame` of a `File`; its evidence is kept if `unfinished` is given."""
    path = file.path
    content, digest = content_and_digest(path)
    if file.segment is None:
        if output.bin_s is None:
            wanted = "--bin-s, the range bin of an image in seconds"
            raise refusal(path, "image", wanted, "none")
        # Not above: echograms need no Pillow.
        from snowsim.io.pairs import BLURRED, read_image_as_echogram

        echogram = read_image_as_echogram(path, output.bin_s, content)
        evidence = tracker.detect(echogram, str(path))
        notes = list(evidence.notes)
        if picture_format(content) == "JPEG":
            notes.append(BLURRED)
        row_db = 10 * np.log10(echogram["Data"].values).mean(axis=1)
        if min(row_db[:EDGE_ROWS].mean(), row_db[-EDGE_ROWS:].mean()) > np.median(row_db):
            notes.append(
                "the picture is bright above and below: expected bright layers on a dark ground"
            )
        return _Frame(path, None, None, digest, evidence, tuple(notes))
    evidence = unfinished.read(digest) if unfinished and output.resume else None
    if evidence is None:
        with noted(path) as told:
            echogram = read_echogram(open_container(path, content))
        evidence = tracker.detect(echogram, str(path))
        evidence = evidence.with_notes(told)
        if unfinished:
            unfinished.keep(digest, evidence)
    return _Frame(path, file.segment, file.number, digest, evidence, evidence.notes)


def _link_and_write(tracker, frames, attributes, output, say):
    """Link the frames of a segment, or of one image, and write their layers; what is drawn."""
    folder = output.folder
    segment = frames[0].segment
    path = layers_file(folder, frames[0])
    found, notes = _linked(tracker, frames, say)
    if segment is None:
        written = _with_rows(found[0], output.bin_s)
    else:
        of_frames = {"day_seg": segment, TOGETHER: attributes[TOGETHER]}
        found = [layers.assign_attrs(of_frames) for layers in found]
        parts, of_times = _one_after_another(found)
        for note in of_times:
            say(f"{path}: {note}")
        notes += of_times
        written = join_frames(parts) if len(parts) > 1 else parts[0]
    is_picked = written["twtt"].notnull().any("slow_time")
    is_picked[0] = True
    if not is_picked.all():
        written = written.isel(layer=is_picked.values)
    written = written.assign_attrs(notes="; ".join(notes), **attributes)
    with written_together():
        # Begun first and renamed last: where it is, the segment is whole.
        write_layers(path, written, force=output.replaces)
        if segment is not None:
            by_number = {frame.number: layers for frame, layers in zip(frames, found, strict=True)}
            write_layer_files(folder, segment, by_number, force=output.replaces)
    n_picks = int(written["twtt"][1:].notnull().sum())
    say(f"{path}: {written.sizes['layer'] - 1} layers below the surface, {n_picks} picks")
    return written.drop_vars(NOT_DRAWN)


def _linked(tracker, frames, say):
    """Layers of the frames of a segment, rounded, a list of datasets; and notes on them."""
    found = []
    notes = []
    for run in _runs(frames):
        if run[0].gap is not None:
            say(f"{run[0].path}: {run[0].gap}")
        picked = tracker.pick_together([frame.evidence for frame in run])
        picked = _renumbered(picked, found)
        for frame in run:
            of_frame = [*frame.notes, *([frame.gap] if frame.gap else [])]
            notes += [f"{frame.path.stem}: {note}" for note in of_frame]
            # Taken from the list, so that what is not rounded is not kept: it may be large.
            found.append(rounded(with_frame(picked.pop(0), frame.path.stem)))
    return found, notes


def _runs(frames):
    """Frames of a segment that follow one another without a gap, list of lists.

    A new run begins where a frame is missing, is too early or too late, or has another averaging.
    Its first frame then has a `gap`.
    """
    runs = []
    for frame in frames:
        last = runs[-1][-1] if runs else None
        reason = None if last is None else _why_apart(last, frame)
        if last is not None and reason is None:
            runs[-1].append(frame)
        else:
            gap = None if last is None else f"not linked with frame {last.number}: {reason}"
            runs.append([replace(frame, gap=gap)])
    return runs


def _why_apart(last, frame):
    """Reason not to link a frame with the last one before it, or None."""
    missing = frame.number - last.number - 1
    if missing:
        return f"{missing} {'frame is' if missing == 1 else 'frames are'} missing between them"
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
