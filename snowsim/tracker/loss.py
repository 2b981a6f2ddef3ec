"""The loss of the tracker: class-balanced cross-entropy over pixels whose class is known."""

import numpy as np
import torch
from torch.nn import functional

from snowsim.echogram import layer_mask

# How far a picked layer may wander along a gap: half of the thinnest first layer in the paper.
REACH_BINS = 8.0


def annotated_pixels(scene, layer_bins, n_range_bins):
    """Pixels whose class the picks of a scene tell, bool (`n_range_bins`, range_line).

    A picked layer is continued across its gaps, linearly between picks and level beyond the first
    and the last. Pixels within `REACH_BINS` of a continuation are unknown, and so are all deeper
    than the deepest pick or continuation by more than that. A layer without any pick, between two
    that have some, counts as background. A scene without `complete_layer_bins` is known everywhere.
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
        known &= picked | (np.abs(bins - continued) > REACH_BINS)
        deepest = np.maximum(deepest, continued)
    known &= bins <= deepest + REACH_BINS
    # A pick counts even where it lies near the gap of another layer.
    return known | layer_mask(layer_bins, n_range_bins)


def cost_of_logits(logits, layer):
    """Cross-entropy of each pixel of logit z and class y, 0 or 1: ``log(1 + exp((1 - 2 y) z))``."""
    return functional.softplus((1 - 2 * layer) * logits.float())


def balanced_cross_entropy(logits, masks, known=None, *, layer_share=None, cost=cost_of_logits):
    """Class-balanced cross-entropy of each output, a sum over pixels and mean of images, (output,).

    `logits` are (output, patch, 1, range_bin, range_line), `masks` bool (patch, range_bin,
    range_line). If `known`, of the same shape, is given, only its pixels count. Layers are weighted
    by the share of background and background by the share of layers: Xie & Tu (2015), ICCV, eq.
    (2). That share is `layer_share` in every image, or each image's own if None. `cost` is the
    cross-entropy of each pixel, ``-y log s(z) - (1 - y) log(1 - s(z))``.
    """
    layer = masks[:, None].float()
    counts = torch.ones_like(layer) if known is None else known[:, None].float()
    if layer_share is None:
        n_pixels = counts.sum(dim=(1, 2, 3), keepdim=True)
        layer_share = (layer * counts).sum(dim=(1, 2, 3), keepdim=True) / n_pixels
    weight = counts * torch.where(masks[:, None], 1 - layer_share, layer_share)
    # As a product of matrices it needs no array of the size of `logits` but the cost.
    return cost(logits, layer).flatten(1) @ weight.flatten() / masks.shape[0]
