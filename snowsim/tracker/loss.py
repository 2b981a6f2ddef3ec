"""The loss of the tracker: class-balanced cross-entropy, of the pixels that picks tell of."""

import numpy as np
import torch
from torch.nn import functional

from snowsim.echogram import layer_mask

# So far a picked layer wanders along a gap; half the least first layer of the paper.
REACH_BINS = 8.0


def annotated_pixels(scene, layer_bins, n_range_bins, reach_bins=REACH_BINS):
    """Where the picks of a scene tell layers from background, bool (`n_range_bins`, range_line).

    Unknown is what lies within `reach_bins` of the continuation of a picked layer across its gaps
    (straight between picks, level beyond the first and the last), and all deeper than the deepest
    pick or continuation by more than that. A layer between two picked ones that has no pick at all
    goes unnoticed. `layer_bins` (layer, range_line) are the scene's, scaled or not; a scene without
    `complete_layer_bins` is known everywhere.
    """
    known = np.ones((n_range_bins, layer_bins.shape[1]), dtype=bool)
    if scene.complete_layer_bins is None:
        return known
    bins = np.arange(n_range_bins)[:, None]
    lines = np.arange(layer_bins.shape[1])
    deepest = np.full(lines.size, -np.inf)
    for layer in layer_bins:
        picked = np.isfinite(layer)
        if not picked.any():
            continue
        continued = np.interp(lines, lines[picked], layer[picked])
        known &= picked | (np.abs(bins - continued) > reach_bins)
        deepest = np.maximum(deepest, continued)
    known &= bins <= deepest + reach_bins
    # A pick is known even where it lies near the gap of another layer.
    return known | layer_mask(layer_bins, n_range_bins)


def cost_of_logits(logits, layer):
    """Cross-entropy of each pixel, ``log(1 + exp((1 - 2 y) z))`` for y of 0 or 1."""
    return functional.softplus((1 - 2 * layer) * logits.float())


def balanced_cross_entropy(logits, masks, known=None, *, layer_share=None, cost=cost_of_logits):
    """Class-balanced cross-entropy of each output, summed over pixels, mean of images, (output,).

    `logits` (output, patch, 1, range_bin, range_line), `masks` and, optionally, `known` of bool
    (patch, range_bin, range_line): pixels that count. Layers weigh by the share of background,
    background by that of layers: Xie & Tu (2015), ICCV, eq. (2), by `layer_share` in every image,
    or if None by the image's own. `cost` gives ``-y log s(z) - (1 - y) log(1 - s(z))``.
    """
    layer = masks[:, None].float()
    counts = torch.ones_like(layer) if known is None else known[:, None].float()
    if layer_share is None:
        n_pixels = counts.sum(dim=(1, 2, 3), keepdim=True)
        layer_share = (layer * counts).sum(dim=(1, 2, 3), keepdim=True) / n_pixels
    weight = counts * torch.where(masks[:, None], 1 - layer_share, layer_share)
    # A product of matrices: nothing of the size of `logits` is made but the cost.
    return cost(logits, layer).flatten(1) @ weight.flatten() / masks.shape[0]
