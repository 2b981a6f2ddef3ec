"""Settings of the tracker: a small modern recipe and the published one."""

from dataclasses import dataclass, replace

from snowsim.settings import check_settings, setting


@dataclass(frozen=True)
class Settings:
    """Network and training of the tracker.

    The defaults are the small recipe, `published` gives the other.
    """

    width: int = setting(4, "[channels] of the first stage; tracker paper: 64", minimum=1)
    n_steps: int = setting(1000, "[gradients] see budgets on the accuracy page", minimum=1)
    batch_size: int = setting(4, "[patches]", minimum=1)
    n_accumulated: int = setting(1, "[gradients] per update", minimum=1)
    n_range_bins: int | None = setting(
        192, "[range bins] of a random crop; null: whole images", minimum=32
    )
    n_range_lines: int | None = setting(
        128, "[range lines] of a random crop; null: whole images", minimum=32
    )
    scales: tuple = setting(
        (1.0,),
        "relative sizes at which images are shown",
        minItems=1,
        items={"type": "number", "exclusiveMinimum": 0, "maximum": 1},
    )
    flip: bool = setting(True, "also show images mirrored left to right")
    augmentation: str = setting(
        "drawn",
        "a scale per batch and half of the images mirrored; copies: an epoch shows every "
        "image, whole, once at each scale and once mirrored, as published",
        enum=("drawn", "copies"),
    )
    optimiser: str = setting("adamw", "sgd: with momentum 0.9", enum=("adamw", "sgd"))
    learning_rate: float = setting(0.001, "the largest of the schedule", exclusiveMinimum=0)
    weight_decay: float = setting(0.01, "of the optimiser", minimum=0)
    schedule: str = setting(
        "one_cycle",
        "of the learning rate: linear rise, cosine fall; steps: a tenth every "
        "n_steps_per_tenth gradients; updates: every as many updates, as published",
        enum=("one_cycle", "steps", "updates"),
    )
    n_steps_per_tenth: int = setting(10000, "[gradients, or updates]", minimum=1)
    published_multipliers: bool = setting(
        False, "rates of the published code: last stage x100, sides x0.01, fuse x0.001, biases x2"
    )
    reduction: str = setting(
        "mean", "of the loss over pixels: mean, or sum as published", enum=("mean", "sum")
    )
    loss: str = setting(
        "logits",
        "cross-entropy of these; sigmoids: of rounded probabilities, logarithms cut, as published",
        enum=("logits", "sigmoids"),
    )
    layer_share: float | None = setting(
        0.03,
        "[of pixels] by which it balances layers and background; null: each image's own, as "
        "published",
        exclusiveMinimum=0,
        exclusiveMaximum=1,
    )
    precision: str = setting(
        "bfloat16", "of the arithmetic; weights are float32 in both", enum=("float32", "bfloat16")
    )
    mask_unannotated: bool = setting(
        False,
        "true leaves pixels that may hold an unpicked layer out of the loss; paper: background",
    )
    network: str = setting(
        "multi_scale",
        "tracker paper; published: and input, first weights and up-sampling of its code",
        enum=("multi_scale", "published"),
    )

    def __post_init__(self):
        object.__setattr__(self, "scales", tuple(self.scales))
        check_settings(self)
        if not self.scales or not all(0 < scale <= 1 for scale in self.scales):
            msg = f"scales must be one or more in (0, 1], got {self.scales}"
            raise ValueError(msg)

    @property
    def n_copies(self):
        """Times an epoch shows an image."""
        return len(self.scales) + self.flip if self.augmentation == "copies" else 1


def published(n_steps=1000, width=64, **other):
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


RECIPES = {"small": Settings(), "published": published()}
