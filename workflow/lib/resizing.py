"""Images at other numbers of range bins and range lines."""

import torch
from torch.nn import functional

AS_THEY_ARE = (1, 1)
LEAST_SIZE = 16  # of an image that the tracker takes


def resized(image, scale):
    """An image with so many times the range bins and range lines, `scale` (bin, line)."""
    if tuple(scale) == AS_THEY_ARE:
        return image
    sizes = zip(image.shape, scale, strict=True)
    size = tuple(max(LEAST_SIZE, round(n * factor)) for n, factor in sizes)
    given = torch.from_numpy(image)[None, None]
    return functional.interpolate(given, size=size, mode="bilinear", antialias=True)[0, 0].numpy()


def resized_rows(row, n_rows, n_resized):
    """Rows of an image of `n_rows` in one of `n_resized`: middles of pixels are counted."""
    return (row + 0.5) * n_resized / n_rows - 0.5
