"""Settings of the tracker: a small modern recipe and the published one."""

from dataclasses import dataclass, replace

from snowsim.settings import check_settings, setting


@dataclass(frozen=True)
class Settings:
    """Network and training of the tracker.

    The defaults are the small recipe, `published` gives the other.
    """

    network: str = setting(
        "multi_scale",
        "tracker paper, trained by the small recipe; published: network, copies of scenes, loss "
        "and updates of its code",
        enum=("multi_scale", "published"),
    )
    width: int = setting(4, "[channels] of the first stage; tracker paper: 64", minimum=1)
    n_averaged: int = setting(
        1,
        "[range lines] that the network averages before all else; published: none",
        minimum=1,
        maximum=2,
    )
    n_steps: int = setting(1000, "[gradients] see budgets on the accuracy page", minimum=1)
    batch_size: int = setting(4, "[patches]", minimum=1)
    n_range_bins: int | None = setting(
        192, "[range bins] of a random crop; null: whole images", minimum=32
    )
    n_range_lines: int | None = setting(
        128, "[range lines] of a random crop; null: whole images", minimum=32
    )
    flip: bool = setting(True, "also show images mirrored left to right")
    learning_rate: float = setting(0.001, "the largest of the schedule", exclusiveMinimum=0)
    weight_decay: float = setting(0.01, "of the optimiser", minimum=0)
    layer_share: float | None = setting(
        0.03,
        "[of pixels] by which it balances layers and background; null: each image's own, as "
        "published",
        exclusiveMinimum=0,
        exclusiveMaximum=1,
    )
    precision: str = setting(
        "bfloat16",
        "of the arithmetic; weights are float32 in both. bfloat16: float32 on a processor without "
        "AVX-512, where that is ten times faster",
        enum=("float32", "bfloat16"),
    )
    mask_unannotated: bool = setting(
        False,
        "true leaves pixels that may hold an unpicked layer out of the loss; paper: background",
    )

    scales: tuple = setting(
        (1.0, 0.75, 0.5, 0.25),
        "published: relative sizes at which an epoch shows every image, and once mirrored",
        listed="one or more in (0, 1]",
        minItems=1,
        exclusiveMinimum=0,
        maximum=1,
    )
    n_accumulated: int = setting(10, "published: [gradients] per update", minimum=1)
    n_steps_per_tenth: int = setting(
        10000, "published: [updates] after which the rate is a tenth", minimum=1
    )
    n_epochs_per_tenth: int | None = setting(
        None,
        "published: [epochs] after which it is, in place of n_steps_per_tenth; code of 2020: 3",
        minimum=1,
    )

    def __post_init__(self):
        check_settings(self)
        object.__setattr__(self, "scales", tuple(self.scales))

    @property
    def n_copies(self):
        """Times an epoch shows an image."""
        return len(self.scales) + self.flip if self.network == "published" else 1


def published(n_steps=1000, width=64, **other):
    """Settings of the published tracker code, github.com/BinaLab/MultiScale; its epochs are 15."""
    recipe = Settings(
        network="published",
        width=width,
        n_steps=n_steps,
        batch_size=1,
        n_range_bins=None,
        n_range_lines=None,
        learning_rate=1e-6,
        weight_decay=2e-4,
        layer_share=None,
        precision="float32",
    )
    return replace(recipe, **other)


RECIPES = {"small": Settings(), "published": published()}
