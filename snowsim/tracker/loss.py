"""The loss of the tracker: class-balanced cross-entropy."""

import torch
from torch.nn import functional


def cost_of_logits(logits, layer):
    """Cross-entropy of each pixel of logit z and class y, 0 or 1: ``log(1 + exp((1 - 2 y) z))``."""
    return functional.softplus((1 - 2 * layer) * logits.float())


def balanced_cross_entropy(logits, masks, *, layer_share=None, cost=cost_of_logits):
    """Class-balanced cross-entropy of each output, a sum over pixels and mean of images, (output,).

    `logits` are (output, patch, 1, range_bin, range_line), `masks` bool (patch, range_bin,
    range_line). Layers are weighted by the share of background and background by the share of
    layers: Xie & Tu (2015), ICCV, eq. (2). That share is `layer_share` in every image, or each
    image's own if None. `cost` is the cross-entropy of each pixel, ``-y log s(z) - (1 - y) log(1 -
    s(z))``.
    """
    layer = masks[:, None].float()
    if layer_share is None:
        layer_share = layer.sum(dim=(1, 2, 3), keepdim=True) / masks[0].numel()
    weight = torch.where(masks[:, None], 1 - layer_share, layer_share)
    # As a product of matrices it needs no array of the size of `logits` but the cost.
    return cost(logits, layer).flatten(1) @ weight.flatten() / masks.shape[0]
