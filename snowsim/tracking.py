"""Tracks layers in echograms with a trained tracker: datasets in memory, or files to files.

`snowsim.io` opens the files and `snowsim.tracker` picks the layers; this module joins the two.
"""

import hashlib
import os
import warnings
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryFile

import numpy as np
import xarray as xr

from snowsim.echogram import SURFACE_NAME, check_choice, from_uint8, named_frame
from snowsim.io import echogram, read_echogram
from snowsim.io.echograms import frame_in
from snowsim.io.files import image_format_of, library_errors, noted, refusal, written_together
from snowsim.io.layers import (
    TOGETHER,
    TRACKED_PREFIX,
    numbers_in_names,
    refuse_existing,
    refuse_other_frames,
    write_layer_files,
    write_layers,
)
from snowsim.io.models import read_tracker, shipped_trackers
from snowsim.io.pairs import BLURRED, read_image
from snowsim.io.pictures import write_picture
from snowsim.progress import with_progress
from snowsim.tracker import (
    canonical,
    checked_card,
    evidence_of,
    layers_of_frames,
    probability_of,
    runner,
)

__all__ = ["Tracker", "list_pretrained", "track_files"]

# A frame follows another if it begins within this time after the end of the other, or within the
# time of this many range lines, whichever is longer.
PAUSE_S = 2.0
PAUSE_LINES = 5
# Limits of the decibels that the greys of an image span where it does not say. Within them, the
# span makes its darkest row the noise floor.
CONTRASTS_DB = (20.0, 100.0)
PICTURE_ENDINGS = (".png", ".jpg", ".jpeg")
EDGE_ROWS = 24  # rows of a picture above its layers, and below them


def list_pretrained():
    """Names that `Tracker.from_pretrained` knows."""
    return sorted(shipped_trackers())


class Tracker:
    """A trained tracker that picks layers in echograms of `snowsim.io.read_echogram`.

    It was trained on synthetic scenes and needs no annotation of the echogram. It resamples range
    bins, averages range lines and levels the surface as in its training; picks are given on the
    echogram's own axes.

    Attributes
    ----------
    card : snowsim.tracker.Card
        Range bins, line spacing and looks that the tracker was made for, and its calibration.

    Examples
    --------
    >>> tracker = Tracker.from_pretrained("universal")  # doctest: +SKIP
    >>> layers = tracker.pick(read_echogram("frame.nc"))  # doctest: +SKIP
    """

    def __init__(self, weights, card, where="weights"):
        self._given = (weights, card, where)
        self.card = checked_card(card, Path(where).with_suffix(".json"))
        self._run = runner(weights, self.card.temperature, where)

    def __repr__(self):
        made_for = f"bins of {1e9 * self.card.bin_s:g} ns, lines {self.card.line_spacing_m:g} m"
        return f"Tracker({self.card.name} {self.card.version}, made for {made_for} apart)"

    def __reduce__(self):
        """How to make it again from a pickle, in another process: onnxruntime's session cannot."""
        return type(self), self._given

    @classmethod
    def from_pretrained(cls, name="universal"):
        """Load one of the trackers that `list_pretrained` names."""
        shipped = shipped_trackers()
        check_choice("a tracker that comes with the package", name, shipped)
        return cls.load(shipped[name])

    @classmethod
    def load(cls, path):
        """Load a tracker from an ONNX file and the card beside it, NAME.json.

        ValueError unless both files are whole, belong together and are of this version.
        """
        if not Path(path).is_file():
            known = ", ".join(list_pretrained()) or "none"
            wanted = f"an ONNX file (or for --model and Tracker.from_pretrained one of: {known})"
            raise refusal(path, "tracker", wanted, "nothing")
        weights, card = read_tracker(path)
        return cls(weights, card, str(path))

    def annotate(self, echogram):
        """Probability of a layer at every pixel, DataArray on the echogram's own axes.

        It is NaN above and below the rows that the tracker was given.
        """
        seen = canonical(echogram, self.card)
        _warn_of(seen.notes)
        probability = probability_of(self._run, seen)
        coordinates = {name: echogram[name] for name in ("twtt", "slow_time")}
        attributes = {"units": "1", "long_name": "probability of a layer"}
        return xr.DataArray(
            probability, coordinates, ("twtt", "slow_time"), "probability", attributes
        )

    def pick(self, echogram):
        """Layers of an echogram, a dataset like that of `snowsim.io.read_layers`.

        `twtt` [s] is (layer, slow_time): layer 0 is the surface, NaN means no pick. `confidence` is
        the probability that a layer lies within 2 of the tracker's range bins of the pick;
        `quality` (1 good, 2 moderate, 3 bad) follows it. Nine of ten layers lie between `twtt_low`
        and `twtt_high`. Notes about the echogram are given as warnings and in `attrs["notes"]`.
        """
        evidence = self.detect(echogram)
        _warn_of(evidence.notes)
        (layers,) = self.pick_together([evidence])
        return layers

    def detect(self, echogram, where="echogram"):
        """Candidates for layers in one frame, for `pick_together`, without the frame's samples."""
        return evidence_of(self._run, canonical(echogram, self.card, where), self.card)

    def pick_together(self, evidence):
        """Layers of frames that follow one another: the same name is the same layer in all frames.

        `evidence` is a list of what `detect` gives for each frame. Datasets are those of `pick`;
        each has only the layers that were picked in its frame.
        """
        found = layers_of_frames(evidence, self.card)
        for frame, layers in zip(evidence, found, strict=True):
            layers.coords["layer"] = _names(layers["layer"].values)
            layers.attrs["tracker"] = f"{self.card.name} {self.card.version}"
            layers.attrs["notes"] = "; ".join(frame.notes)
        return found


def _warn_of(notes):
    """Issue each note as a UserWarning of the calling public function."""
    for note in notes:
        warnings.warn(note, UserWarning, stacklevel=3)


def _names(numbers):
    """Names of layers by number; the first is the surface."""
    return [SURFACE_NAME, *(f"{TRACKED_PREFIX}{number}" for number in numbers[1:])]


@dataclass(frozen=True, eq=False)
class _Frame:
    """A file and the candidates for layers that were detected in it.

    `segment` is None for an image. `number` is None until `_by_segment` if the file has none. `gap`
    is the note that says why this frame is not linked with the one before, else None.
    """

    path: Path
    segment: str | None
    number: int | None
    evidence: object
    notes: tuple
    gap: str | None = None


def track_files(
    paths,
    folder,
    *,
    model="universal",
    png=False,
    bin_s=None,
    force=False,
    say=print,
    progress=None,
):
    """Track echograms and write their layers to a folder.

    Frames of a segment that follow one another are tracked as one. Each file gives
    `NAME_layers.nc`, and each segment the layer files of `snowsim.io.layers`. An image gives
    `NAME_layers.nc` alone, with rows of the image beside travel times.

    Parameters
    ----------
    paths : sequence of path_like
    folder : path_like
        It is made if it is missing.
    model : str
        Name of `list_pretrained`, or path of an ONNX file.
    png : bool
        Draw picks on each echogram, as `NAME_picks.png`.
    bin_s : float, optional
        Range bin of images [s].
    force : bool
        Replace files that exist; a file beside its own input is never replaced.
    say : callable
        It is called with one line for each note, error and file written.
    progress : callable, optional
        It wraps the list of files, as tqdm does; by default in a progress bar.

    Returns
    -------
    int
        Number of files that failed.

    Raises
    ------
    ValueError
        In one line, before anything is tracked: the folder cannot be written to, two files have the
        same name, or the tracker is damaged.
    """
    tracker = Tracker.load(shipped_trackers().get(model, model))
    paths = [Path(path) for path in paths]
    _refuse_equal_names(paths)
    folder = _writable_folder(folder)
    named = {path: named_frame(path) for path in paths}
    n_failed = 0
    frames = []
    progress = progress or partial(with_progress, unit="file")
    for path in progress(paths):
        try:
            _refuse_outputs(path, named, folder, png, force)
            frame = _load_and_detect(tracker, path, named[path], bin_s, frames)
        except (ValueError, OSError) as error:
            n_failed += 1
            say(f"error: {error}")
            continue
        for note in frame.notes:
            say(f"{path}: {note}")
        frames.append(frame)
    for segment in _by_segment(frames):
        try:
            _track_segment(tracker, segment, folder, png, bin_s, force, say)
        except (ValueError, OSError) as error:
            n_failed += len(segment)
            say(f"error: {error}")
    return n_failed


def _refuse_equal_names(paths):
    """Refuse two files whose outputs would have the same name."""
    first = {}
    for path in paths:
        if path.stem in first:
            wanted = "files of different names, for their layers are named by them"
            raise refusal(path, "name", wanted, f"{first[path.stem]} too")
        first[path.stem] = path


def _writable_folder(folder):
    """Path of the folder, made if it is missing; ValueError unless it can be written to."""
    try:
        os.makedirs(
            folder, exist_ok=True
        )  # not of a Path: an empty name would become the current folder
        with TemporaryFile(dir=folder):
            return Path(folder)
    except OSError as error:
        wanted = "a folder that can be written to"
        raise refusal(folder, "output", wanted, error.strerror) from error


def _refuse_outputs(path, named, folder, png, force):
    """Refuse outputs that exist, and a folder that holds layer files of other frames.

    `named` has the segment and the number in the name of every file that is tracked.
    """
    segment, _ = named[path]
    if segment is not None and path.suffix.lower() not in PICTURE_ENDINGS:
        numbers = [number for other, number in named.values() if other == segment]
        refuse_other_frames(folder, segment, numbers)
    for output in (_layers_file(folder, path), *([_picture_file(folder, path)] if png else [])):
        if output.exists() and folder.resolve() == path.resolve().parent:
            wanted = "none beside the input, also with force (give another folder)"
            raise refusal(output, "file", wanted, "one")
        if not force:
            refuse_existing(output)


def _layers_file(folder, path):
    """File of the layers of an input, beside the layer files of its segment."""
    return folder / f"{path.stem}_layers.nc"


def _picture_file(folder, path):
    """File of the picks drawn on the echogram of an input."""
    return folder / f"{path.stem}_picks.png"


def _load_and_detect(tracker, path, named, bin_s, others):
    """`_Frame` of a file; ValueError where it is the same frame as one of the `others`.

    `named` are the segment and the number in its name, or (None, None).
    """
    if path.is_fifo():
        raise refusal(path, "file", "one that can be read more than once", "a pipe")
    image_format = image_format_of(path)
    if image_format is not None:
        echogram = _image_as_echogram(path, bin_s)
        evidence = tracker.detect(echogram, str(path))
        notes = list(evidence.notes)
        if image_format == "JPEG":
            notes.append(BLURRED)
        row_db = 10 * np.log10(echogram["Data"].values).mean(axis=1)
        if min(row_db[:EDGE_ROWS].mean(), row_db[-EDGE_ROWS:].mean()) > np.median(row_db):
            notes.append(
                "the picture is bright above and below: expected bright layers on a dark ground"
            )
        return _Frame(path, None, None, evidence, tuple(notes))
    with noted(path) as told:
        echogram = read_echogram(path)
    segment, number = named if named[0] else frame_in(echogram, path)
    for other in others:
        if number is not None and (other.segment, other.number) == (segment, number):
            raise refusal(path, "frame", "one file of each", f"that of {other.path}")
    evidence = tracker.detect(echogram, str(path))
    return _Frame(path, segment, number, evidence, (*told, *evidence.notes))


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


def _by_segment(frames):
    """Frames of each segment in order of their numbers, list of lists; each image is alone.

    Frames without a number are numbered after the others, in order of time.
    """
    segments = {}
    for frame in frames:
        segments.setdefault(frame.segment or ("image", frame.path), []).append(frame)
    return [_in_order(of_segment) for of_segment in segments.values()]


def _in_order(frames):
    """Frames of a segment in order of their numbers; those without one follow, by time."""
    known = [frame for frame in frames if frame.number is not None]
    others = [frame for frame in frames if frame.number is None]
    others.sort(key=lambda frame: frame.evidence.slow_time[0])
    first = 1 + max((frame.number for frame in known), default=0)
    added = [replace(frame, number=number) for number, frame in enumerate(others, first)]
    return sorted(known, key=lambda frame: frame.number) + added


def _track_segment(tracker, frames, folder, png, bin_s, force, say):
    """Track the frames of a segment, or one image, and write their layers and pictures."""
    attributes = {TOGETHER: _digest(frames, tracker.card)} if frames[0].segment else {}
    found = []
    for run in _runs(frames):
        if run[0].gap is not None:
            say(f"{run[0].path}: {run[0].gap}")
        layers_of_run = tracker.pick_together([frame.evidence for frame in run])
        for frame, layers in zip(run, _renumbered(layers_of_run, found), strict=True):
            notes = [*frame.notes, *([frame.gap] if frame.gap else [])]
            found.append(layers.assign_attrs(notes="; ".join(notes), **attributes))
    written = {
        _layers_file(folder, frame.path): _as_written(frame, layers, bin_s)
        for frame, layers in zip(frames, found, strict=True)
    }
    with written_together():
        for path, layers in written.items():
            write_layers(path, layers, force=force)
        if frames[0].segment is not None:
            by_number = {frame.number: layers for frame, layers in zip(frames, found, strict=True)}
            write_layer_files(folder, frames[0].segment, by_number, force=force)
    for path, layers in written.items():
        n_picks = int(np.isfinite(layers["twtt"].values[1:]).sum())
        say(f"{path}: {layers.sizes['layer'] - 1} layers below the surface, {n_picks} picks")
    # Last, so that a picture that cannot be drawn stops no file.
    for frame, layers in zip(frames, written.values(), strict=True) if png else ():
        _draw_picks(frame.path, layers, folder, bin_s)


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
        layers.assign_coords(layer=_names(numbers_in_names(layers) + n_above))
        for layers in layers_of_run
    ]


def _as_written(frame, layers, bin_s):
    """Layers dataset of a frame as it is written: without layers that have no pick in it.

    A frame of a segment gets its name as `granule`, an image the rows of its picks.
    """
    picked = np.isfinite(layers["twtt"].values).any(axis=1)
    picked[0] = True
    layers = layers.isel(layer=picked)
    if frame.segment is not None:
        granule = f"{frame.segment}_{frame.number:03d}"
        return layers.assign_attrs(granule=granule)
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
