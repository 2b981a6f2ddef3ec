"""Settings of the conditional GAN."""

from dataclasses import dataclass

from snowsim.cgan.inputs import METHODS
from snowsim.echogram import check_choice

CHOICES = {
    "method": METHODS,
    "statistics": ("scene", "pixel"),
    "adversarial": ("bce", "none"),
    "precision": ("float32", "bfloat16"),
}


@dataclass(frozen=True)
class Settings:
    """Networks and training of the conditional GAN; `method: pix2pix` is as published.

    Attributes
    ----------
    method : str
        `pix2pix`, as published; `depth`: both networks know the depth, and noise is more than
        dropout.
    width : int
        Channels of the outermost stage of both networks; 64 as published.
    depth, n_strided : int
        Halvings of the generator and of the discriminator; 8 and 3 (patches of 70 pixels) as
        published.
    n_steps, batch_size : int
        Gradient steps of each network; patches a step.
    n_range_bins, n_range_lines : int or None
        Size of random crops; None takes whole scenes. Of `pix2pix`, that scenes are resized to;
        multiples of ``2**depth``.
    statistics : str
        Of `depth`: normalise by those of each `scene`, as pix2pix always does: they change with its
        height. `pixel`: over the channels of each pixel, so that a layer is drawn alike in scenes
        of any height.
    learning_rate, beta1, beta2 : float
        Of Adam; the rate is constant for half the steps, then falls linearly to zero; that of
        `pix2pix` is constant.
    l1_weight : float
        Of the mean absolute error against the adversarial loss, eq. (7) of Yari et al. (2021).
    adversarial : str
        `bce`, as published, or `none`: without a discriminator, on the L1 term alone.
    dropout : float
        Share of dropped values in the noisy stages of the generator.
    precision : str
        Arithmetic, `float32` or `bfloat16`.
    """

    method: str = "depth"
    width: int = 16
    depth: int = 5
    n_strided: int = 3
    n_steps: int = 2000
    batch_size: int = 1
    n_range_bins: int | None = 256
    n_range_lines: int | None = 192
    statistics: str = "pixel"
    learning_rate: float = 5e-4
    beta1: float = 0.5
    beta2: float = 0.999
    l1_weight: float = 100.0
    adversarial: str = "bce"
    dropout: float = 0.0
    precision: str = "bfloat16"

    def __post_init__(self):
        for name in ("n_steps", "batch_size", "n_range_bins", "n_range_lines"):
            value = getattr(self, name)
            if value is not None and value < 1:
                msg = f"{name} must be at least 1, got {value}"
                raise ValueError(msg)
        if not 0 <= self.dropout < 1:
            msg = f"dropout must lie in [0, 1), got {self.dropout}"
            raise ValueError(msg)
        if self.l1_weight < 0 or not self.learning_rate > 0:
            msg = "expected l1_weight >= 0 and learning_rate > 0, "
            msg += f"got {self.l1_weight} and {self.learning_rate}"
            raise ValueError(msg)
        for name, choices in CHOICES.items():
            check_choice(name, getattr(self, name), choices)
        sizes = (self.n_range_bins, self.n_range_lines)
        if self.method == "pix2pix" and any(not size or size % 2**self.depth for size in sizes):
            msg = f"pix2pix: n_range_bins and n_range_lines must be multiples of 2**{self.depth}, "
            msg += f"got {sizes[0]} and {sizes[1]}"
            raise ValueError(msg)
