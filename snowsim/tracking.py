"""Layers of echograms without any annotation: a trained tracker, and files tracked with it.

Only `snowsim.io` opens files, only `snowsim.picking` knows how to pick: this joins them.
"""

import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from snowsim.echogram import bin_size_s, from_uint8
from snowsim.io import read_echogram
from snowsim.io.guard import container_of, existing, is_zarr, refusal
from snowsim.io.images import read_image
from snowsim.io.layer_files import (
    named_frame,
    refuse_existing,
    write_layer_files,
    write_layers,
)
from snowsim.io.pictures import write_picture
from snowsim.io.trackers import read_tracker, shipped_trackers
from snowsim.picking import (
    canonical,
    checked_card,
    evidence_of,
    layers_of_frames,
    probability_of,
)
from snowsim.picking.network import network

__all__ = ["Tracker", "list_pretrained", "track_files"]

SURFACE_NAME = "surface"
# Frames of a segment follow one another where no more time lies between them.
PAUSE = np.timedelta64(2, "s")
FIRST_TIME = np.datetime64("2000-01-01", "ns")
# Decibels that an image's greys stand for where it does not tell: as many as make its darkest row
# the noise floor, within limits.
CONTRASTS_DB = (20.0, 100.0)


def list_pretrained():
    """Names that `Tracker.from_pretrained` knows."""
    return sorted(shipped_trackers())


class Tracker:
    """A trained tracker, for echograms as `snowsim.io.read_echogram` gives them.

    Trained on synthetic scenes; no annotation of the echogram is used. Range lines, range bins and
    the surface are brought to what it was trained on, and back.

    Attributes
    ----------
    card : snowsim.picking.Card
        What it was made for.

    Examples
    --------
    >>> tracker = Tracker.from_pretrained("universal")  # doctest: +SKIP
    >>> layers = tracker.pick(read_echogram("frame.nc"))  # doctest: +SKIP
    """

    def __init__(self, weights, card, where="weights"):
        self.card = checked_card(card, where)
        self._run = network(weights, where)

    @classmethod
    def from_pretrained(cls, name="universal"):
        """A tracker that comes with the package; see `list_pretrained`."""
        shipped = shipped_trackers()
        if name not in shipped:
            known = ", ".join(sorted(shipped)) or "none"
            msg = f"no weights named {name!r} come with the package, but {known}"
            raise ValueError(msg)
        return cls.load(shipped[name])

    @classmethod
    def load(cls, path):
        """A tracker of an ONNX file, with its card in JSON beside it.

        ValueError unless both are whole, belong together and are of this version.
        """
        weights, card = read_tracker(path)
        return cls(weights, card, str(path))

    def annotate(self, echogram):
        """Probability of a layer at every pixel, DataArray on the echogram's own axes.

        NaN above and below what the tracker was shown.
        """
        seen = self._canonical(echogram)
        probability = probability_of(self._run, seen, self.card)
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
        seen = self._canonical(echogram)
        (layers,) = layers_of_frames([evidence_of(self._run, seen, self.card)], self.card)
        return self._labelled(layers, seen.notes)

    def see(self, echogram, where="echogram"):
        """Evidence of one frame for `pick_together`; it does not keep the echogram's samples."""
        seen = canonical(echogram, self.card, where)
        seen.notes.extend(self.card.outside(echogram))
        return evidence_of(self._run, seen, self.card).without_data()

    def pick_together(self, evidence):
        """Layers of frames that follow one another, list of `see`: row i is one layer in all."""
        found = layers_of_frames(evidence, self.card)
        notes = [frame.canonical.notes for frame in evidence]
        return [self._labelled(*each) for each in zip(found, notes, strict=True)]

    def _canonical(self, echogram):
        seen = canonical(echogram, self.card)
        seen.notes.extend(self.card.outside(echogram))
        for note in seen.notes:
            warnings.warn(note, UserWarning, stacklevel=3)
        return seen

    def _labelled(self, layers, notes):
        names = [SURFACE_NAME, *(f"snow_{number}" for number in range(1, layers.sizes["layer"]))]
        about = {"tracker": f"{self.card.name} {self.card.version}", "notes": "; ".join(notes)}
        return layers.assign_coords(layer=names).assign_attrs(about)


@dataclass(frozen=True, eq=False)
class _Seen:
    """A file and what the tracker saw in it; an image has no frame of a segment."""

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
    progress=iter,
):
    """Track echograms and write their layers to a folder.

    Frames of a segment that follow one another are tracked as one. For each, `NAME_layers.nc`; for
    each segment the layer files of `snowsim.io.layer_files`; of an image, rows in `NAME_layers.nc`
    alone.

    Parameters
    ----------
    paths : sequence of path_like
    folder : path_like
    model : str
        One of `list_pretrained`, or an ONNX file.
    png : bool
        Draw picks on each echogram, as `NAME_picks.png`.
    bin_s : float, optional
        Range bin of images [s].
    force : bool
        Write over files that are there.
    say, progress : callable
        Told a line of every file that fails, and of what was written; and wrapping the files.

    Returns
    -------
    int
        Files that failed.
    """
    shipped = shipped_trackers()
    tracker = Tracker.load(shipped.get(model, model))
    folder = Path(folder)
    n_failed = 0
    seen = []
    taken = {}
    for path in progress([Path(path) for path in paths]):
        try:
            frame = _see(tracker, path, bin_s, seen)
            _check_outputs(frame, folder, taken, png, force)
        except (ValueError, OSError) as error:
            n_failed += 1
            say(f"error: {error}")
            continue
        for note in frame.evidence.canonical.notes:
            say(f"{path}: {note}")
        taken[_key(frame)] = path
        seen.append(frame)
    for frames in _segments(seen):
        try:
            _write_segment(tracker, frames, folder, png, bin_s, force, say)
        except (ValueError, OSError) as error:
            n_failed += len(frames)
            say(f"error: {error}")
    return n_failed


def _see(tracker, path, bin_s, seen):
    """What the tracker sees in a file, and of which segment it is."""
    echogram = _read(path, bin_s)
    evidence = tracker.see(echogram, str(path))
    if echogram.attrs.get("source_format") == "image":
        return _Seen(path, evidence, None, None)
    segment, number = named_frame(path)
    if segment:
        return _Seen(path, evidence, segment, number)
    day = str(echogram["slow_time"].values[0])[:10].replace("-", "")
    segment = echogram.attrs.get("day_seg") or f"{day}_01"
    number = 1 + max((each.number for each in seen if each.segment == segment), default=0)
    return _Seen(path, evidence, str(segment), number)


def _key(frame):
    """What of two files must differ: both would be written to one."""
    return frame.path.stem if frame.segment is None else (frame.segment, frame.number)


def _outputs(frame, folder, png):
    """Files beside the layer files of a frame."""
    paths = [folder / f"{frame.path.stem}_layers.nc"]
    if png:
        paths.append(folder / f"{frame.path.stem}_picks.png")
    return paths


def _check_outputs(frame, folder, taken, png, force):
    """Refuse a second file of one frame, and files that are there."""
    if _key(frame) in taken:
        found = f"that of {taken[_key(frame)]}"
        raise refusal(frame.path, "frame", "one file of each", found)
    if not force:
        for path in _outputs(frame, folder, png):
            refuse_existing(path)


def _read(path, bin_s):
    """Echogram dataset of a file, or of a PNG image with `bin_s`."""
    path = existing(path, directory=True)
    if (path.is_dir() and not is_zarr(path)) or container_of(path) != "png":
        return read_echogram(path)
    if bin_s is None:
        raise refusal(path, "image", "--bin-s, the range bin of an image in seconds", "none")
    image, numbers = read_image(path)
    floor_db = numbers.get("noise_floor_db", 0.0)
    darkest = image.mean(axis=1).min()
    contrast_db = np.clip(10 * (255 / max(darkest, 1.0) - 1), *CONTRASTS_DB)
    power_db = from_uint8(image, floor_db, numbers.get("maximum_db", floor_db + contrast_db))
    n_lines = image.shape[1]
    unknown = ("slow_time", np.full(n_lines, np.nan))
    along = dict.fromkeys(("Latitude", "Longitude", "Elevation", "Surface"), unknown)
    power = (10 ** (power_db / 10)).astype(np.float32)
    coordinates = {
        "twtt": ("twtt", bin_s * np.arange(len(image)), {"units": "s"}),
        "slow_time": FIRST_TIME + np.arange(n_lines) * np.timedelta64(1, "ms"),
    }
    content = {"Data": (("twtt", "slow_time"), power)} | along
    return xr.Dataset(content, coordinates, {"source_format": "image"})


def _segments(seen):
    """Frames by segment, in order; every image by itself."""
    segments = {}
    for frame in seen:
        segments.setdefault(frame.segment or ("image", frame.path), []).append(frame)
    return [sorted(frames, key=lambda each: each.number or 0) for frames in segments.values()]


def _runs(frames):
    """Frames of a segment in runs without a gap in number or time."""
    runs = []
    last = None
    for frame in frames:
        follows = last is not None and frame.number == last.number + 1
        if follows:
            pause = _times(frame)[0] - _times(last)[-1]
            same = (
                frame.evidence.canonical.grid.n_averaged == last.evidence.canonical.grid.n_averaged
            )
            follows = same and np.timedelta64(0) < pause <= PAUSE
        if follows:
            runs[-1].append(frame)
        else:
            runs.append([frame])
        last = frame
    return runs


def _times(frame):
    return frame.evidence.canonical.echogram["slow_time"].values


def _write_segment(tracker, frames, folder, png, bin_s, force, say):
    """Layers of all frames of a segment, or of an image, to files."""
    found = []
    for run in _runs(frames):
        found.extend(_apart(found, tracker.pick_together([frame.evidence for frame in run])))
    n_layers = max(layers.sizes["layer"] for layers in found)
    found = [_with_layers(layers, n_layers) for layers in found]
    if frames[0].segment is not None:
        by_number = {frame.number: layers for frame, layers in zip(frames, found, strict=True)}
        write_layer_files(folder, frames[0].segment, by_number, force=force)
    for frame, layers in zip(frames, found, strict=True):
        picked = np.isfinite(layers["twtt"].values).any(axis=1)
        picked[0] = True
        layers = layers.isel(layer=picked)
        path, *pictures = _outputs(frame, folder, png)
        if frame.segment is None:
            rows = (layers["twtt"] / bin_s).assign_attrs(units="1", long_name="row of the image")
            layers = layers.assign(row=rows)
        write_layers(path, layers, force=force)
        for picture in pictures:
            _draw(picture, _read(frame.path, bin_s), layers, frame.evidence.canonical)
        n_picks = int(np.isfinite(layers["twtt"].values[1:]).sum())
        say(f"{path}: {layers.sizes['layer'] - 1} layers below the surface, {n_picks} picks")


def _apart(before, found):
    """Layers of one run, in rows below those of the runs before it; the surface stays row 0."""
    n_above = max((layers.sizes["layer"] - 1 for layers in before), default=0)
    return [_renamed(layers, n_above) for layers in found]


def _renamed(layers, n_above):
    names = layers["layer"].values
    rows = [int(name.removeprefix("snow_")) + n_above for name in names[1:]]
    layers = layers.assign_coords(layer=[SURFACE_NAME, *(f"snow_{row}" for row in rows)])
    return _with_layers(layers, n_above + len(names))


def _with_layers(layers, n_layers):
    """The same with `n_layers` rows by name, those that are new without picks."""
    names = [SURFACE_NAME, *(f"snow_{row}" for row in range(1, n_layers))]
    if list(layers["layer"].values) == names:
        return layers
    fill = {"quality": np.uint8(1), "type": np.uint8(2)}
    return layers.reindex(
        layer=names,
        fill_value=fill | dict.fromkeys(("twtt", "twtt_low", "twtt_high", "confidence"), np.nan),
    )


def _draw(path, echogram, layers, seen):
    """Picks on the echogram's own pixels, grey as the tracker saw them."""
    power = echogram["Data"].transpose("twtt", "slow_time").values
    bottom_db = seen.noise_floor_db - 10
    with np.errstate(divide="ignore", invalid="ignore"):
        power_db = np.nan_to_num(10 * np.log10(power), nan=bottom_db, neginf=bottom_db)
    scaled = (power_db - bottom_db) * (255 / (seen.maximum_db - bottom_db))
    image = np.rint(np.clip(scaled, 0, 255)).astype(np.uint8)
    rows = (layers["twtt"].values - float(echogram["twtt"].values[0])) / bin_size_s(echogram)
    write_picture(path, image, rows, layers["quality"].values)
