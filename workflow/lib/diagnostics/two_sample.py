"""How often a classifier tells crops of the flight from crops of real pictures, or observed scenes from drawn ones.

Half of the decisions are right by chance. No crop decides about another of its own frame, or scene.
"""

import numpy as np
import xarray as xr
from scipy.special import expit

from lib.diagnostics.realism import TOP_BINS, correlation, homogeneous_snow, rows_between

AIR_SHAPE, SNOW_SHAPE, MEANS_SHAPE = (32, 32), (12, 32), (12, 10)  # rows, range lines or columns
KINDS = ("air", "homogeneous snow", "100 m means")
RIDGE, N_NEWTON = 1.0, 20  # weight of the squared coefficients; steps of Newton's method
N_BOOTSTRAP, N_SHOWN = 500, 6


def crops(image, shape):
    """Crops that tile an image, one column of crops after the other; those with unknown pixels are left out."""
    n_rows, n_columns = shape
    tiles = [
        image[row : row + n_rows, column : column + n_columns]
        for column in range(0, image.shape[1] - n_columns + 1, n_columns)
        for row in range(0, image.shape[0] - n_rows + 1, n_rows)
    ]
    return [tile for tile in tiles if np.isfinite(tile).all()]


def picture_crops(picture, row_s):
    """Crops of air and of homogeneous snow, rows brought to a length [s] by taking the nearest."""
    found = {}
    for kind, image, shape in (
        ("air", picture.power_db[picture.air], AIR_SHAPE),
        ("homogeneous snow", homogeneous_snow(picture), SNOW_SHAPE),
    ):
        if image is not None:
            rows = np.rint(np.arange(0, len(image) - 1, row_s / picture.row_s)).astype(int)
            found[kind] = crops(image[rows], shape)
    return found


def means_crops(means):
    """Crops of the upper 100 m means."""
    return {"100 m means": crops(rows_between(means, TOP_BINS), MEANS_SHAPE)}


def texture(crop):
    """Statistics of a crop less its mean: none of them tells the level or the gain of a picture."""
    deviation = crop - crop.mean()
    spread = deviation.std()
    return [
        *(spread, (deviation**3).mean() / spread**3, (deviation**4).mean() / spread**4),
        *correlation(deviation - deviation.mean(axis=1, keepdims=True), (1, 2), axis=1),
        *correlation(deviation, (1, 2), axis=0),
        deviation.mean(axis=0).std(),
        deviation.mean(axis=1).std(),
    ]


def textures(frames):
    """Statistics of the crops of every frame, (crop, statistic)."""
    return [np.array([texture(crop) for crop in frame]) for frame in frames]


def fitted(features, truth):
    """Logistic regression with a ridge, both classes of equal weight; gives a function from features to decisions."""
    mean, spread = features.mean(axis=0), features.std(axis=0) + 1e-12

    def terms(of):
        return np.column_stack([np.ones(len(of)), (of - mean) / spread])

    x, weight = terms(features), np.where(truth, 0.5 / truth.mean(), 0.5 / (1 - truth.mean()))
    ridge = RIDGE * np.diag([1e-6, *np.ones(features.shape[1])])
    found = np.zeros(x.shape[1])
    for _ in range(N_NEWTON):
        share = expit(x @ found)
        curvature = (x * (weight * share * (1 - share))[:, None]).T @ x + ridge
        found += np.linalg.solve(curvature, x.T @ (weight * (truth - share)) - ridge @ found)
    return lambda of: terms(of) @ found > 0


def decisions(one, other, *, n_splits, fit=fitted):
    """Whether crops of two classes are classified rightly, two lists of bool (crop,) by frame; None if impossible.

    Classes are lists of frames, each an array (crop, ...) of what `fit` takes, with truth of bool
    (crop,), to give a function to decisions. Frames are dealt out to splits; those of each are
    decided by what saw the others alone.
    """
    filled = [
        sum(map(len, frames[split::n_splits]))
        for frames in (one, other)
        for split in range(n_splits)
    ]
    if not all(filled):
        return None
    right = [[], []]
    for split in range(n_splits):
        seen = [
            np.concatenate(
                [
                    frame
                    for place, frame in enumerate(frames)
                    if place % n_splits != split and len(frame)
                ]
            )
            for frames in (one, other)
        ]
        decide = fit(np.concatenate(seen), np.repeat([False, True], [len(part) for part in seen]))
        for side, frames in enumerate((one, other)):
            right[side] += [
                decide(frame) == bool(side) for frame in frames[split::n_splits] if len(frame)
            ]
    return right


def accuracy(right, *, rng):
    """Mean share of right decisions over two classes, and its 95 % interval by the bootstrap over what each lists.

    `right` are two lists of shares, or of decisions, of what is drawn as a whole; NaN where there
    is None.
    """
    if right is None:
        return np.nan, np.nan, np.nan
    drawn = [rng.choice(part, (N_BOOTSTRAP, len(part))).mean(axis=1) for part in right]
    return (
        np.mean([np.mean(part) for part in right]),
        *np.percentile(np.mean(drawn, axis=0), [2.5, 97.5]),
    )


def accuracy_of_crops(one, other, *, rng):
    """Accuracy by texture of lists of frames' crops, in halves; few frames leave only their crops to be drawn from."""
    right = decisions(textures(one), textures(other), n_splits=2)
    return accuracy(right and [np.concatenate(part) for part in right], rng=rng)


def compare(flight, real, *, rng):
    """Flight against real, accuracy and interval, and one real frame against the other, accuracy: by kind of crop.

    `flight` and `real`: crops by kind, of every frame. A real frame's two halves stand for two
    frames.
    """
    found = {}
    for kind in KINDS:
        of_flight, of_real = (
            [frame[kind] for frame in frames if kind in frame] for frames in (flight, real)
        )
        one, other = (
            [part[: len(part) // 2], part[len(part) // 2 :]] for part in (of_real[0], of_real[-1])
        )
        found[kind] = (
            *accuracy_of_crops(of_flight, of_real, rng=rng),
            accuracy_of_crops(one, other, rng=rng)[0],
        )
    return found


def crops_dataset(flight, real):
    """Some crops of either side for a figure, variables such as "real, air" (crop, row, column), spread over frames."""
    shown = {}
    for side, frames in (("flight", flight), ("real", real)):
        for kind in KINDS:
            held = [crop for frame in frames for crop in frame.get(kind, [])]
            if held:
                chosen = [held[i] for i in np.linspace(0, len(held) - 1, N_SHOWN).astype(int)]
                shown[f"{side}, {kind}"] = (
                    ("crop", f"row of {kind}", f"column of {kind}"),
                    np.array(chosen),
                )
    return xr.Dataset(shown)
