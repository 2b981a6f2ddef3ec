"""Non-maximum suppression of an edge map to edges of one pixel, as is usual for HED."""

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import correlate1d

from snowsim.compiling import compiled
from snowsim.limits import check_values

SMOOTHING_RADIUS = 1
ORIENTATION_RADIUS = 4
BORDER = 5  # [pixels] width of the border within which edges fade
CURVATURE = 1e-5  # added to the curvature along range lines, as in the published code
STEEP = 1e150  # stands for the tangent of a right angle; its square is finite
MARGIN = 1.01  # factor by which a neighbour must be stronger to suppress a pixel


def check_prediction(prediction, where="image"):
    """Edge map as float64 (range_bin, range_line).

    A map that is empty or leaves [0, 1] is refused by a ValueError that names `where`.
    """
    prediction = np.asarray(prediction)
    if prediction.ndim != 2 or prediction.size == 0:
        msg = f"{where}: prediction must be (range_bin, range_line) and not empty, "
        msg += f"got shape {prediction.shape}"
        raise ValueError(msg)
    if prediction.dtype != bool:
        check_values(f"{where}: prediction", prediction, 0, 1)
    return prediction.astype(np.float64)


def suppress(
    prediction: ArrayLike, *, added_curvature: float = CURVATURE, where: str = "image"
) -> NDArray[np.floating]:
    """Non-maximum-suppressed edge map: a ridge of any width becomes a line of about one pixel.

    Parameters
    ----------
    prediction : array_like, (range_bin, range_line)
        Edge probability in [0, 1].
    added_curvature : float
        Constant that the published code adds to ``Oxx``, see below. It changes the orientation of
        ridges fainter than about 0.001. With 0, a map divided by ten has the same edges, divided by
        ten.
    where : str
        Name of the image, for errors.

    Returns
    -------
    ndarray of float64, (range_bin, range_line)
        The smoothed map where it is a maximum across the edge, else 0. Edges fade at the border:
        the outermost pixels are 0 and the next four are multiplied by 1/5, 2/5, 3/5 and 4/5.

    Raises
    ------
    ValueError
        If the prediction is empty, not a number or outside [0, 1].

    Notes
    -----
    Networks such as HED (Xie & Tu 2015, ICCV) are scored after this suppression, which the
    structured edge detector of Dollar & Zitnick (2015), IEEE TPAMI 37, introduced. ``E`` is the map
    under a triangle filter of radius 1, and ``O = mod(atan(Oyy sign(-Oxy) / (Oxx + 1e-5)), pi)`` is
    the orientation of its ridges, from second differences after a further triangle filter of radius
    4. A pixel is suppressed where ``1.01 E`` is below the bilinear value of ``E`` one pixel away
    along ``+-(cos O, sin O)``. Since ``sign(0) = 0``, a ridge that stays in one range bin over a
    dozen range lines has ``O = 0`` and keeps its width; thinning narrows it. The published code
    does the same.

    Examples
    --------
    A sloping ridge, 5 range bins wide, becomes a line; bins per range line before and after:

    >>> from_ridge = np.arange(40)[:, None] - 10 - 0.3 * np.arange(60)
    >>> ridge = np.exp(-((from_ridge / 2) ** 2))
    >>> n_bins = [(edges[:, 10:50] > 0.2).sum(axis=0) for edges in (ridge, suppress(ridge))]
    >>> [round(float(n.mean())) for n in n_bins]
    [5, 1]
    """
    smoothed = triangle_filter(check_prediction(prediction, where), SMOOTHING_RADIUS)
    edges = _keep_maxima(smoothed, tangent_across(smoothed, added_curvature))
    n_rows, n_lines = edges.shape
    edges *= _border_fade(n_rows)[:, None]
    edges *= _border_fade(n_lines)
    return edges


def triangle_filter(image, radius):
    """Image smoothed by a separable triangle filter of unit sum, mirrored at its border."""
    steps = np.arange(-radius, radius + 1)
    weights = (radius + 1 - np.abs(steps)) / (radius + 1) ** 2
    by_bin = correlate1d(image, weights, axis=0, mode="reflect")
    return correlate1d(by_bin, weights, axis=1, mode="reflect")


def tangent_across(smoothed, added_curvature=CURVATURE):
    """Tangent of the angle between range lines and the direction across the ridges of a map."""
    averaged = triangle_filter(smoothed, ORIENTATION_RADIUS)
    slope_bin = _gradient(averaged, 0)
    bin_bin = _gradient(slope_bin, 0)
    bin_line = _gradient(slope_bin, 1)
    line_line = _gradient(_gradient(averaged, 1), 1)
    # A denominator of 0 stands for a right angle; 0 / 0, where sign(0) = 0, gives 0.
    with np.errstate(divide="ignore", invalid="ignore"):
        tangent = bin_bin * np.sign(-bin_line) / (line_line + added_curvature)
    return np.nan_to_num(tangent, posinf=STEEP, neginf=-STEEP)


def _gradient(image, axis):
    """Central differences along an axis, one-sided at borders, 0 along an axis of one pixel."""
    return np.gradient(image, axis=axis) if image.shape[axis] > 1 else np.zeros_like(image)


def _border_fade(length):
    """Factor of every row or column: k / 5 for the k-th from the nearer border, at most 1."""
    width = min(BORDER, length // 2)
    if width == 0:
        return np.ones(length)
    steps = np.minimum(np.arange(length), np.arange(length)[::-1])
    return np.minimum(steps / width, 1)


@compiled()
def _keep_maxima(smoothed, tangent):
    """Smoothed map where it has a maximum along the direction of `tangent`, 0 elsewhere."""
    n_rows, n_lines = smoothed.shape
    kept = np.zeros_like(smoothed)
    for row in range(n_rows):
        for line in range(n_lines):
            value = smoothed[row, line]
            if value == 0:
                continue
            along_line = 1 / np.sqrt(1 + tangent[row, line] ** 2)
            along_row = tangent[row, line] * along_line
            strongest = value * MARGIN
            if strongest < _between_pixels(smoothed, row - along_row, line - along_line):
                continue
            if strongest < _between_pixels(smoothed, row + along_row, line + along_line):
                continue
            kept[row, line] = value
    return kept


@compiled()
def _between_pixels(image, y, x):
    """Value of an image at row y and column x, clipped to the image, by bilinear interpolation."""
    n_rows, n_lines = image.shape
    y = min(max(y, 0.0), max(n_rows - 1.001, 0.0))
    x = min(max(x, 0.0), max(n_lines - 1.001, 0.0))
    top = int(y)
    left = int(x)
    bottom = min(top + 1, n_rows - 1)
    right = min(left + 1, n_lines - 1)
    dy = y - top
    dx = x - left
    above = (1 - dx) * image[top, left] + dx * image[top, right]
    below = (1 - dx) * image[bottom, left] + dx * image[bottom, right]
    return (1 - dy) * above + dy * below
