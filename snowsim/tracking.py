"""Layers of echograms without any annotation: a trained tracker, and files tracked with it.

Only `snowsim.io` opens files, only `snowsim.tracker` knows how to pick: this joins them.
"""

import os
import re
import warnings
from dataclasses import dataclass, replace
from functools import partial
from numbers import Integral
from pathlib import Path
from tempfile import TemporaryFile

import numpy as np
import xarray as xr

from snowsim.echogram import check_choice, from_uint8, named_frame
from snowsim.io import echogram, read_echogram
from snowsim.io.containers import opened
from snowsim.io.files import content_of, library_errors, picture_format, refusal
from snowsim.io.layers import (
    layer_numbers,
    refuse_existing,
    refuse_other_frames,
    write_layer_files,
    write_layers,
)
from snowsim.io.models import read_tracker, shipped_trackers
from snowsim.io.pairs import BLURRED, read_image
from snowsim.io.pictures import write_picture
from snowsim.progress import shown
from snowsim.tracker import (
    canonical,
    checked_card,
    evidence_of,
    layers_of_frames,
    probability_of,
    runner,
)

__all__ = ["Tracker", "list_pretrained", "track_files"]

SURFACE_NAME = "surface"
# Only such a name becomes a folder: attributes of a file may hold anything.
SEGMENT = re.compile(r"[0-9]{8}_[0-9]{2}")
# Frames of a segment follow one another where no more time lies between them, or no more range
# lines would.
PAUSE_S = 2.0
PAUSE_LINES = 5
# Decibels that an image's greys stand for where it does not tell: as many as make its darkest row
# the noise floor, within limits.
CONTRASTS_DB = (20.0, 100.0)
PICTURE_ENDINGS = (".png", ".jpg", ".jpeg")
EDGE_ROWS = 24  # above the layers of a picture, and below them


def list_pretrained():
    """Names that `Tracker.from_pretrained` knows."""
    return sorted(shipped_trackers())


class Tracker:
    """A trained tracker, for echograms as `snowsim.io.read_echogram` gives them.

    Trained on synthetic scenes; no annotation of the echogram is used. Range lines, range bins and
    the surface are brought to what it was trained on, and back.

    Attributes
    ----------
    card : snowsim.tracker.Card
        What it was made for.

    Examples
    --------
    >>> tracker = Tracker.from_pretrained("universal")  # doctest: +SKIP
    >>> layers = tracker.pick(read_echogram("frame.nc"))  # doctest: +SKIP
    """

    def __init__(self, weights, card, where="weights"):
        self.card = checked_card(card, Path(where).with_suffix(".json"))
        self._run = runner(weights, self.card.temperature, where)

    def __repr__(self):
        made_for = f"bins of {1e9 * self.card.bin_s:g} ns, lines {self.card.line_spacing_m:g} m"
        return f"Tracker({self.card.name} {self.card.version}, made for {made_for} apart)"

    @classmethod
    def from_pretrained(cls, name="universal"):
        """A tracker that comes with the package; see `list_pretrained`."""
        shipped = shipped_trackers()
        check_choice("a tracker that comes with the package", name, shipped)
        return cls.load(shipped[name])

    @classmethod
    def load(cls, path):
        """A tracker of an ONNX file, with its card in JSON beside it.

        ValueError unless both are whole, belong together and are of this version.
        """
        if not Path(path).is_file():
            known = ", ".join(list_pretrained()) or "none"
            wanted = f"an ONNX file (or for --model and Tracker.from_pretrained one of: {known})"
            raise refusal(path, "tracker", wanted, "nothing")
        weights, card = read_tracker(path)
        return cls(weights, card, str(path))

    def annotate(self, echogram):
        """Probability of a layer at every pixel, DataArray on the echogram's own axes.

        NaN above and below what the tracker was shown.
        """
        seen = canonical(echogram, self.card)
        _warn(seen.notes)
        probability = probability_of(self._run, seen)
        coordinates = {name: echogram[name] for name in ("twtt", "slow_time")}
        attributes = {"units": "1", "long_name": "probability of a layer"}
        return xr.DataArray(
            probability, coordinates, ("twtt", "slow_time"), "probability", attributes
        )

    def pick(self, echogram):
        """Layers of an echogram, a dataset as of `snowsim.io.read_layers`.

        `twtt` [s] on (layer, slow_time), layer 0 the surface, NaN where none is picked; `quality`
        (1 good, 2 moderate, 3 bad) by `confidence`, the probability that a layer lies within 2 of
        the tracker's range bins; `twtt_low` and `twtt_high`, between which nine of ten lie. What a
        reader should know is warned of, and stands in `attrs["notes"]`.
        """
        evidence = self.see(echogram)
        _warn(evidence.canonical.notes)
        (layers,) = self.pick_together([evidence])
        return layers

    def see(self, echogram, where="echogram"):
        """Evidence of one frame for `pick_together`; it does not keep the echogram's samples."""
        return evidence_of(self._run, canonical(echogram, self.card, where), self.card)

    def pick_together(self, evidence):
        """Layers of frames that follow one another, list of `see`: a name is one layer in all.

        A frame has the layers picked in it.
        """
        found = layers_of_frames(evidence, self.card)
        for frame, layers in zip(evidence, found, strict=True):
            layers.coords["layer"] = _names(layers["layer"].values)
            layers.attrs["tracker"] = f"{self.card.name} {self.card.version}"
            layers.attrs["notes"] = "; ".join(frame.canonical.notes)
        return found


def _warn(notes):
    """Warn the caller of a public function, a line each, of what a reader should know."""
    for note in notes:
        warnings.warn(note, UserWarning, stacklevel=3)


def _names(numbers):
    """Names of layers, the surface first, by their numbers."""
    return [SURFACE_NAME, *(f"snow_{number}" for number in numbers[1:])]


@dataclass(frozen=True, eq=False)
class _Seen:
    """A file and what the tracker saw in it; an image has no segment, not all frames a number."""

    path: Path
    evidence: object
    segment: str | None
    number: int | None


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

    Frames of a segment that follow one another are tracked as one. For each, `NAME_layers.nc`; for
    each segment the layer files of `snowsim.io.layers`; of an image, rows in `NAME_layers.nc`
    alone.

    Parameters
    ----------
    paths : sequence of path_like
    folder : path_like
        Made where there is none.
    model : str
        One of `list_pretrained`, or an ONNX file.
    png : bool
        Draw picks on each echogram, as `NAME_picks.png`.
    bin_s : float, optional
        Range bin of images [s].
    force : bool
        Write over files that are there, but for those beside the input that they are named by.
    say, progress : callable
        Told a line of every file that fails, and of what was written; and wrapping the files, by
        default in a bar.

    Returns
    -------
    int
        Files that failed.

    Raises
    ------
    ValueError
        Before anything is tracked, in one line: a folder that cannot be written to, two files of
        one name, a damaged tracker.
    """
    tracker = Tracker.load(shipped_trackers().get(model, model))
    paths = [Path(path) for path in paths]
    _check_names(paths)
    folder = _made(folder)
    named = {}
    for path in paths:
        segment, number = named_frame(path)
        named.setdefault(segment, set()).add(number)
    n_failed = 0
    seen = []
    progress = progress or partial(shown, unit="file")
    for path in progress(paths):
        try:
            _check_outputs(path, folder, named, png, force)
            frame = _see(tracker, path, bin_s, seen)
        except (ValueError, OSError) as error:
            n_failed += 1
            say(f"error: {error}")
            continue
        for note in frame.evidence.canonical.notes:
            say(f"{path}: {note}")
        seen.append(frame)
    for frames in _segments(_numbered(seen)):
        try:
            _write_segment(tracker, frames, folder, png, bin_s, force, say)
        except (ValueError, OSError) as error:
            n_failed += len(frames)
            say(f"error: {error}")
    return n_failed


def _check_names(paths):
    """Refuse two files whose outputs would have one name."""
    first = {}
    for path in paths:
        if path.stem in first:
            wanted = "files of different names, for their layers are named by them"
            raise refusal(path, "name", wanted, f"{first[path.stem]} too")
        first[path.stem] = path


def _made(folder):
    """The folder, made where there is none; ValueError unless it can be written to."""
    try:
        os.makedirs(folder, exist_ok=True)  # not of a Path: one of no name is the folder one is in
        with TemporaryFile(dir=folder):
            return Path(folder)
    except OSError as error:
        wanted = "a folder that can be written to"
        raise refusal(folder, "output", wanted, error.strerror) from error


def _see(tracker, path, bin_s, seen):
    """What the tracker sees in a file, and of which segment it is."""
    echogram = _read(path, bin_s)
    if echogram.attrs.get("source_format") == "image":
        evidence = tracker.see(echogram, str(path))
        if echogram.attrs["picture"] == "JPEG":
            evidence.canonical.notes.append(BLURRED)
        if _dark_on_bright(echogram):
            note = "the picture is bright above and below: expected bright layers on a dark ground"
            evidence.canonical.notes.append(note)
        return _Seen(path, evidence, None, None)
    segment, number = _frame_of(path, echogram)
    for other in seen:
        if number is not None and (other.segment, other.number) == (segment, number):
            raise refusal(path, "frame", "one file of each", f"that of {other.path}")
    return _Seen(path, tracker.see(echogram, str(path)), segment, number)


def _frame_of(path, echogram):
    """Segment and number of the frame, by the file's name or what is in it; the number may be None.

    Open Polar Radar's tools write `granule`, `segment_path` and `frame`.
    """
    for name in (path, str(echogram.attrs.get("granule", ""))):
        segment, number = named_frame(name)
        if segment is not None:
            return segment, number
    told = [str(echogram.attrs.get(name, "")) for name in ("day_seg", "segment_path")]
    segment = told[0] or told[1]
    if not segment:
        day = str(echogram["slow_time"].values[0])[:10].replace("-", "")
        return f"{day}_01", None
    if not SEGMENT.fullmatch(segment):
        raise refusal(path, "day_seg", "a segment such as 20120330_04", segment)
    number = echogram.attrs.get("frame")
    counted = isinstance(number, Integral) and 0 < number < 1000
    return segment, int(number) if counted else None


def _numbered(seen):
    """The same, with numbers of frames that files do not tell: after the others, by time."""
    last = {}
    for frame in seen:
        last[frame.segment] = max(last.get(frame.segment, 0), frame.number or 0)
    numbers = {frame.path: frame.number for frame in seen}
    for frame in sorted(seen, key=lambda each: _times(each)[0]):
        if frame.segment is not None and frame.number is None:
            last[frame.segment] += 1
            numbers[frame.path] = last[frame.segment]
    return [replace(frame, number=numbers[frame.path]) for frame in seen]


def _outputs(path, folder, png):
    """Files beside the layer files of a frame."""
    paths = [folder / f"{path.stem}_layers.nc"]
    if png:
        paths.append(folder / f"{path.stem}_picks.png")
    return paths


def _check_outputs(path, folder, named, png, force):
    """Refuse files that are there, and frames of a segment beside layer files of others of it."""
    segment, _ = named_frame(path)
    if segment is not None and path.suffix.lower() not in PICTURE_ENDINGS:
        refuse_other_frames(folder, segment, named[segment])
    for output in _outputs(path, folder, png):
        if output.exists() and folder.resolve() == path.resolve().parent:
            wanted = "none beside the input, also with force (give another folder)"
            raise refusal(output, "file", wanted, "one")
        if not force:
            refuse_existing(output)


def _read(path, bin_s):
    """Echogram dataset of a file, or of an image with `bin_s`."""
    with library_errors(path):
        content = content_of(path)
        form = picture_format(content)
        if form is None:
            return read_echogram(opened(path, content))
    if bin_s is None:
        raise refusal(path, "image", "--bin-s, the range bin of an image in seconds", "none")
    image, numbers = read_image(path, content=content)
    floor_db = numbers.get("noise_floor_db", 0.0)
    darkest = image.mean(axis=1).min()
    contrast_db = np.clip(10 * (255 / max(darkest, 1.0) - 1), *CONTRASTS_DB)
    power_db = from_uint8(image, floor_db, numbers.get("maximum_db", floor_db + contrast_db))
    power = (10 ** (power_db / 10)).astype(np.float32)
    attributes = {"source_format": "image", "picture": form}
    return echogram(power, twtt=bin_s * np.arange(len(power)), attrs=attributes)


def _dark_on_bright(echogram):
    """Whether a picture is brighter above and below its layers than among them."""
    row_db = 10 * np.log10(echogram["Data"].values).mean(axis=1)
    return min(row_db[:EDGE_ROWS].mean(), row_db[-EDGE_ROWS:].mean()) > np.median(row_db)


def _segments(seen):
    """Frames by segment, in order; every image by itself."""
    segments = {}
    for frame in seen:
        segments.setdefault(frame.segment or ("image", frame.path), []).append(frame)
    return [sorted(frames, key=lambda each: each.number or 0) for frames in segments.values()]


def _runs(frames, say):
    """Frames of a segment in runs without a gap in number or time; the latter are said."""
    runs = []
    for frame in frames:
        last = runs[-1][-1] if runs else None
        if last is None or frame.number != last.number + 1:
            runs.append([frame])
            continue
        reason = _why_apart(last, frame)
        if reason is None:
            runs[-1].append(frame)
            continue
        note = f"not linked with frame {last.number}: {reason}"
        frame.evidence.canonical.notes.append(note)
        say(f"{frame.path}: {note}")
        runs.append([frame])
    return runs


def _why_apart(last, frame):
    """Why the next frame does not go on where the last one ends, None if it does."""
    pause_s = (_times(frame)[0] - _times(last)[-1]) / np.timedelta64(1, "s")
    longest_s = max(PAUSE_S, PAUSE_LINES * _interval_s(last), PAUSE_LINES * _interval_s(frame))
    if pause_s <= 0:
        return f"it begins {-pause_s:.3g} s before that ends"
    if pause_s > longest_s:
        return f"it begins {pause_s:.3g} s after that ends, more than {longest_s:.3g} s"
    own, others = (each.evidence.canonical.grid.n_averaged for each in (frame, last))
    return None if own == others else f"of its range lines {own} are averaged, of that {others}"


def _interval_s(frame):
    """Median time from a range line to the next [s], 0 for a single one."""
    steps = np.diff(_times(frame)) / np.timedelta64(1, "s")
    return float(np.median(steps)) if steps.size else 0.0


def _times(frame):
    return frame.evidence.canonical.echogram["slow_time"].values


def _write_segment(tracker, frames, folder, png, bin_s, force, say):
    """Layers of all frames of a segment, or of an image, to files."""
    found = []
    for run in _runs(frames, say):
        found.extend(_apart(found, tracker.pick_together([frame.evidence for frame in run])))
    if frames[0].segment is not None:
        by_number = {frame.number: layers for frame, layers in zip(frames, found, strict=True)}
        write_layer_files(folder, frames[0].segment, by_number, force=force)
    to_draw = []
    for frame, layers in zip(frames, found, strict=True):
        picked = np.isfinite(layers["twtt"].values).any(axis=1)
        picked[0] = True
        layers = layers.isel(layer=picked)
        path, *pictures = _outputs(frame.path, folder, png)
        if frame.segment is None:
            rows = (layers["twtt"] / bin_s).assign_attrs(units="1", long_name="row of the image")
            layers = layers.assign(row=rows)
            layers["slow_time"].attrs["comment"] = "invented: a picture tells no times"
        else:
            layers = layers.assign_attrs(granule=f"{frame.segment}_{frame.number:03d}")
        write_layers(path, layers, force=force)
        to_draw.extend((picture, layers, frame.path) for picture in pictures)
        n_picks = int(np.isfinite(layers["twtt"].values[1:]).sum())
        say(f"{path}: {layers.sizes['layer'] - 1} layers below the surface, {n_picks} picks")
    # Behind all files: no picture stops them.
    for picture, layers, path in to_draw:
        with library_errors(picture, "picture: expected layers that can be drawn"):
            write_picture(picture, layers, [_read(path, bin_s)])


def _apart(before, found):
    """Layers of one run, named after those of the runs before it; the surface is one in all."""
    n_above = max((int(layer_numbers(layers).max()) for layers in before), default=0)
    return [layers.assign_coords(layer=_names(layer_numbers(layers) + n_above)) for layers in found]
