"""Settings of the tracker, with two recipes: a small modern one and the published one."""

from dataclasses import dataclass, replace

from snowsim.settings import Checked, setting


@dataclass(frozen=True)
class Settings(Checked):
    """Network and training of the tracker.

    The defaults are the small recipe; `published_settings` gives the published one.
    """

    network: str = setting(
        "multi_scale",
        "multi_scale: network of the tracker paper, small recipe; published: also copies of "
        "scenes, loss and updates as in its code",
        choices=("multi_scale", "published"),
    )
    width: int = setting(4, "[channels] of the first stage; tracker paper: 64", low=1)
    n_averaged: int = setting(
        1,
        "[range lines] that the network averages before its first stage; published: 1",
        low=1,
        high=2,
    )
    n_steps: int = setting(1000, "[gradients] of the whole training", low=1)
    batch_size: int = setting(4, "[patches] of one gradient", low=1)
    n_range_bins: int | None = setting(
        192, "[range bins] of a random crop; null: whole images", low=32
    )
    n_range_lines: int | None = setting(
        128, "[range lines] of a random crop; null: whole images", low=32
    )
    flip: bool = setting(True, "also show images mirrored left to right")
    learning_rate: float = setting(0.001, "largest rate of the schedule", low=0, above=True)
    weight_decay: float = setting(0.01, "weight decay of the optimiser", low=0)
    layer_share: float | None = setting(
        0.03,
        "[1] share of layer pixels by which the loss balances layers and background; null: each "
        "image's own, as published",
        low=0,
        above=True,
        high=0.999,
    )
    precision: str = setting(
        "bfloat16",
        "precision of the arithmetic; weights are always float32. A processor without AVX-512 "
        "computes bfloat16 in float32, which is ten times faster there",
        choices=("float32", "bfloat16"),
    )
    scales: tuple = setting(
        (1.0, 0.75, 0.5, 0.25),
        "published: relative sizes in which an epoch shows every image",
        low=0,
        above=True,
        high=1,
    )
    n_accumulated: int = setting(10, "published: [gradients] per update", low=1)
    n_steps_per_tenth: int = setting(
        10000, "published: [updates] after which the rate falls to a tenth", low=1
    )
    n_epochs_per_tenth: int | None = setting(
        None,
        "published: [epochs] after which the rate falls to a tenth, in place of "
        "n_steps_per_tenth; code of 2020: 3",
        low=1,
    )

    def __post_init__(self):
        super().__post_init__()
        object.__setattr__(self, "scales", tuple(self.scales))

    @property
    def n_copies(self):
        """Number of times that an epoch shows an image."""
        return len(self.scales) + self.flip if self.network == "published" else 1


def published_settings(n_steps=1000, width=64, **other):
    """Settings of the published tracker code, github.com/BinaLab/MultiScale, with 15 epochs."""
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


RECIPES = {"small": Settings(), "published": published_settings()}
