"""Settings of the tracker: a small modern recipe and the published one."""

from dataclasses import dataclass, replace

from snowsim.echogram import check_choice

CHOICES = {
    "optimiser": ("adamw", "sgd"),
    "schedule": ("one_cycle", "steps", "updates"),
    "reduction": ("mean", "sum"),
    "precision": ("float32", "bfloat16"),
    "network": ("multi_scale", "published"),
    "augmentation": ("drawn", "copies"),
    "loss": ("logits", "sigmoids"),
}


@dataclass(frozen=True)
class Settings:
    """Network and training of the tracker.

    The defaults are the small recipe, `published` gives the other.

    Attributes
    ----------
    width : int
        Channels of the first stage; 64 as published.
    n_steps, batch_size, n_accumulated : int
        Gradients, one per batch; patches a gradient; gradients summed before the weights change.
    n_range_bins, n_range_lines : int or None
        Size of the random crops, cut after scaling; None takes whole images.
    scales : tuple of float
        Sizes an image is shown at.
    flip : bool
        Show images mirrored left to right, too.
    augmentation : str
        `drawn`: a scale per batch, and half of the images mirrored. `copies`, as published: an
        epoch shows every image, whole, once at each scale, mask and image resized alike, and once
        mirrored, in random order; one without layers costs nothing; gradients that fill no update
        by the end of an epoch join the first of the next.
    optimiser : str
        `adamw` or `sgd` (momentum 0.9), with `learning_rate` and `weight_decay`.
    schedule : str
        `one_cycle`: linear rise over a tenth of the steps, cosine to zero; `steps`: a tenth every
        `n_steps_per_tenth` gradients; `updates`: every as many updates of the weights, as
        published.
    published_multipliers : bool
        Rates of the published code: last stage x100, sides x0.01, fuse x0.001, biases x2 without
        decay, but for those of the last stage (a misspelt key).
    reduction : str
        Loss per image: `sum` over its pixels as published, or `mean`.
    loss : str
        Cross-entropy of `logits`, or as published of `sigmoids`, logarithms cut at -100: beyond
        float32, no gradient.
    layer_share : float or None
        Share of layers in an image by which the loss balances them and background; None, as
        published: each image's own, so that the threshold which suits an image follows its number
        of layers, and one without costs nothing.
    precision : str
        Arithmetic, `float32` or `bfloat16`.
    mask_unannotated : bool
        Leave out of the loss what `annotated_pixels` calls unknown; else it counts as background,
        as published.
    network : str
        `multi_scale`, or `published`: the same with the input, first weights and up-sampling of
        the published code.
    """

    width: int = 4
    n_steps: int = 1000
    batch_size: int = 4
    n_accumulated: int = 1
    n_range_bins: int | None = 192
    n_range_lines: int | None = 128
    scales: tuple = (1.0,)
    flip: bool = True
    augmentation: str = "drawn"
    optimiser: str = "adamw"
    learning_rate: float = 1e-3
    weight_decay: float = 1e-2
    schedule: str = "one_cycle"
    n_steps_per_tenth: int = 10_000
    published_multipliers: bool = False
    reduction: str = "mean"
    loss: str = "logits"
    layer_share: float | None = 0.03
    precision: str = "bfloat16"
    mask_unannotated: bool = False
    network: str = "multi_scale"

    def __post_init__(self):
        object.__setattr__(self, "scales", tuple(self.scales))
        for name in ("n_steps", "batch_size", "n_accumulated", "n_steps_per_tenth"):
            n = getattr(self, name)
            if n < 1:
                msg = f"{name} must be at least 1, got {n}"
                raise ValueError(msg)
        if not self.learning_rate > 0 or self.weight_decay < 0:
            got = f"got {self.learning_rate} and {self.weight_decay}"
            msg = f"expected learning_rate > 0 and weight_decay >= 0, {got}"
            raise ValueError(msg)
        if self.layer_share is not None and not 0 < self.layer_share < 1:
            msg = f"layer_share must lie between 0 and 1, got {self.layer_share}"
            raise ValueError(msg)
        if not self.scales or not all(0 < scale <= 1 for scale in self.scales):
            msg = f"scales must be one or more in (0, 1], got {self.scales}"
            raise ValueError(msg)
        for name, choices in CHOICES.items():
            check_choice(name, getattr(self, name), choices)

    @property
    def n_copies(self):
        """Times an epoch shows an image."""
        return len(self.scales) + self.flip if self.augmentation == "copies" else 1


def published(n_steps, width=64, **other):
    """Settings of the published tracker code, github.com/BinaLab/MultiScale; its epochs are 15."""
    recipe = Settings(
        width=width,
        n_steps=n_steps,
        batch_size=1,
        n_accumulated=10,
        n_range_bins=None,
        n_range_lines=None,
        scales=(1.0, 0.75, 0.5, 0.25),
        augmentation="copies",
        optimiser="sgd",
        learning_rate=1e-6,
        weight_decay=2e-4,
        schedule="updates",
        published_multipliers=True,
        reduction="sum",
        loss="sigmoids",
        layer_share=None,
        precision="float32",
        network="published",
    )
    return replace(recipe, **other)
