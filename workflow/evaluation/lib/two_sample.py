"""How often a classifier tells crops of the flight from real ones, or observed scenes from drawn.

Half of the decisions are right by chance. No crop decides about another of its own frame, or scene.
"""

import numpy as np
import xarray as xr
from scipy.special import expit

from evaluation.lib.realism import TOP_BINS, correlation, homogeneous_snow, rows_between

# Rows, range lines or columns.
AIR_SHAPE = (32, 32)
SNOW_SHAPE = (12, 32)
MEANS_SHAPE = (12, 10)
KINDS = ("air", "homogeneous snow", "100 m means")
RIDGE = 1.0  # weight of the squared coefficients
N_NEWTON = 20  # steps of Newton's method
N_BOOTSTRAP = 500
N_SHOWN = 6


def crops(image, shape):
    """Crops that tile an image, one column of crops after the other; all their pixels are known."""
    n_rows, n_columns = shape
    tiles = [
        image[row : row + n_rows, column : column + n_columns]
        for column in range(0, image.shape[1] - n_columns + 1, n_columns)
        for row in range(0, image.shape[0] - n_rows + 1, n_rows)
    ]
    return [tile for tile in tiles if np.isfinite(tile).all()]


def picture_crops(picture, row_s):
    """Crops of air and of homogeneous snow, rows brought to a length [s] by taking the nearest."""

    def resampled(image):
        rows = np.rint(np.arange(0, len(image) - 1, row_s / picture.row_s)).astype(int)
        return image[rows]

    found = {"air": crops(resampled(picture.power_db[picture.air]), AIR_SHAPE)}
    snow = homogeneous_snow(picture)
    if snow is not None:
        found["homogeneous snow"] = crops(resampled(snow), SNOW_SHAPE)
    return found


def means_crops(means):
    """Crops of the upper 100 m means."""
    return {"100 m means": crops(rows_between(means, TOP_BINS), MEANS_SHAPE)}


def texture(crop):
    """Statistics of a crop less its mean: none of them tells the level or the gain of a picture."""
    deviation = crop - crop.mean()
    spread = deviation.std()
    asymmetry = (deviation**3).mean() / spread**3
    peakedness = (deviation**4).mean() / spread**4
    along = correlation(deviation - deviation.mean(axis=1, keepdims=True), (1, 2), axis=1)
    down = correlation(deviation, (1, 2), axis=0)
    of_lines = deviation.mean(axis=0).std()
    of_rows = deviation.mean(axis=1).std()
    return [spread, asymmetry, peakedness, *along, *down, of_lines, of_rows]


def textures(frames):
    """Statistics of the crops of every frame, (crop, statistic)."""
    return [np.array([texture(crop) for crop in frame]) for frame in frames]


def fitted(features, truth):
    """Logistic regression with a ridge, classes of equal weight: from features to decisions."""
    mean = features.mean(axis=0)
    spread = features.std(axis=0) + 1e-12

    def terms(of):
        return np.column_stack([np.ones(len(of)), (of - mean) / spread])

    x = terms(features)
    weight = np.where(truth, 0.5 / truth.mean(), 0.5 / (1 - truth.mean()))
    ridge = RIDGE * np.diag([1e-6, *np.ones(features.shape[1])])
    found = np.zeros(x.shape[1])
    for _ in range(N_NEWTON):
        share = expit(x @ found)
        of_crop = weight * share * (1 - share)
        curvature = (x * of_crop[:, None]).T @ x + ridge
        gradient = x.T @ (weight * (truth - share)) - ridge @ found
        found += np.linalg.solve(curvature, gradient)
    return lambda of: terms(of) @ found > 0


def decisions(one, other, *, n_splits, fit=fitted):
    """Whether crops of two classes are classified rightly, two lists of bool (crop,) by frame.

    Classes are lists of frames, each an array (crop, ...) of what `fit` takes, with truth of bool
    (crop,), to give a function to decisions. Frames are dealt out to splits; those of each are
    decided by what saw the others alone. None where a split of a class has no crop.
    """
    right = ([], [])
    dealt = [
        [_filled(frames[split::n_splits]) for split in range(n_splits)] for frames in (one, other)
    ]
    if not all(dealt[0]) or not all(dealt[1]):
        return None
    for split in range(n_splits):
        seen = [_others(frames, split, n_splits) for frames in (one, other)]
        truth = np.repeat([False, True], [len(part) for part in seen])
        decide = fit(np.concatenate(seen), truth)
        for side, splits in enumerate(dealt):
            right[side].extend(decide(frame) == bool(side) for frame in splits[split])
    return right


def _filled(frames):
    return [frame for frame in frames if len(frame)]


def _others(frames, split, n_splits):
    """Crops of the frames of all splits but one, in the order of frames."""
    seen = [frame for place, frame in enumerate(frames) if place % n_splits != split]
    return np.concatenate(_filled(seen))


def accuracy(right, *, rng):
    """Mean share of right decisions over two classes, and its 95 % interval by the bootstrap.

    `right` are two lists of shares, or of decisions, of what is drawn as a whole; NaN where there
    is None.
    """
    if right is None:
        return np.nan, np.nan, np.nan
    drawn = [rng.choice(part, (N_BOOTSTRAP, len(part))).mean(axis=1) for part in right]
    low, high = np.percentile(np.mean(drawn, axis=0), [2.5, 97.5])
    return np.mean([np.mean(part) for part in right]), low, high


def accuracy_of_crops(one, other, *, rng):
    """Accuracy by texture of lists of frames' crops, in halves, and its interval.

    Few frames leave only their crops to be drawn from.
    """
    right = decisions(textures(one), textures(other), n_splits=2)
    return accuracy(right and [np.concatenate(part) for part in right], rng=rng)


def compare(flight, real, *, rng):
    """Flight against real, accuracy and interval, and one real frame against the other, by kind.

    `flight` and `real`: crops by kind, of every frame. A real frame's two halves stand for two
    frames.
    """
    found = {}
    for kind in KINDS:
        of_flight = [frame[kind] for frame in flight if kind in frame]
        of_real = [frame[kind] for frame in real if kind in frame]
        of_both = accuracy_of_crops(of_flight, of_real, rng=rng)
        first = _halves(of_real[0])
        last = _halves(of_real[-1])
        between_real, *_ = accuracy_of_crops(first, last, rng=rng)
        found[kind] = (*of_both, between_real)
    return found


def _halves(frame):
    middle = len(frame) // 2
    return [frame[:middle], frame[middle:]]


def crops_dataset(flight, real):
    """Some crops of either side for a figure, spread over frames.

    Variables such as "real, air" (crop, row, column).
    """
    shown = {}
    for side, frames in {"flight": flight, "real": real}.items():
        for kind in KINDS:
            held = [crop for frame in frames for crop in frame.get(kind, [])]
            if held:
                chosen = np.linspace(0, len(held) - 1, N_SHOWN).astype(int)
                dims = ("crop", f"row of {kind}", f"column of {kind}")
                shown[f"{side}, {kind}"] = (dims, np.array(held)[chosen])
    return xr.Dataset(shown)
