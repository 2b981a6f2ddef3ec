"""Settings of PHY, the conditional GAN and the tracker, and their recipes.

Each setting is a field of a dataclass, with its default, its limits, its unit and its meaning.
Every start of the workflow imports this module, so it imports no stage.
"""

from dataclasses import dataclass, field, fields, replace
from types import NoneType
from typing import get_args

from snowsim.echogram import check_choice
from snowsim.limits import check_count, check_values


def setting(default, about, **limits):
    """A setting with its default, `[unit] meaning, source`, and its limits.

    Limits of a number are those of `check_values`; those of a word are its `choices`.
    """
    return field(default=default, metadata={"about": about, "limits": limits})


class Checked:
    """Base of dataclasses of settings, which are checked when they are made.

    ValueError, naming the setting in its `group`, unless each has the right type and is within its
    limits.
    """

    group = ""

    def __post_init__(self):
        for each in fields(self):
            _check(f"{self.group}{each.name}", getattr(self, each.name), each)


def _check(name, value, each):
    """Refuse a value that has another type than a field, or is not within its limits."""
    limits = each.metadata["limits"]
    kinds = get_args(each.type) or (each.type,)
    if value is None and NoneType in kinds:
        return
    if str in kinds:
        check_choice(name, value, limits["choices"])
    elif bool in kinds:
        if not isinstance(value, bool):
            msg = f"{name} must be true or false, got {value!r}"
            raise ValueError(msg)
    elif tuple in kinds:
        if not isinstance(value, list | tuple) or len(value) == 0:
            msg = f"{name} must be a list of one number or more, got {value!r}"
            raise ValueError(msg)
        for number in value:
            check_values(name, number, **limits, number=True)
    else:
        if int in kinds:
            check_count(name, value, limits["low"])
        check_values(name, value, **limits, number=True)


@dataclass(frozen=True)
class PhySettings(Checked):
    """Setting of PHY beside the choice of recipe, as measured in the flight or as printed."""

    n_looks: float | None = setting(
        16,
        "[looks] as in the benchmark (benchmark.n_looks); paper: 100; null: as in the flight",
        low=1,
    )


# The paper's section III averages 100 input lines to one line of its image. Here these lie within
# its 5.2 m, over which layers move by 0.2 bins: that would widen a variance of 10 by 0.003.
PHY = {"measured": PhySettings(), "paper": PhySettings(n_looks=100)}


@dataclass(frozen=True)
class CganSettings(Checked):
    """Networks and training of the conditional GAN; pix2pix is that of Isola et al. (2017)."""

    method: str = setting(
        "measured",
        "networks know depths and how bright PHY expects layers and snow; pix2pix: the mask alone, "
        "paper",
        choices=("measured", "pix2pix"),
    )
    width: int = setting(16, "[channels] of the outermost stage; paper scale 64", low=1)
    depth: int = setting(5, "[halvings] of the generator; pix2pix: 8", low=2, high=10)
    n_steps: int = setting(2000, "[gradient steps] paper scale: 200 epochs", low=1)
    n_range_bins: int | None = setting(
        256,
        "[range bins] of a random crop; null: whole scenes; pix2pix: 256 of scenes resized to 286",
        low=32,
    )
    n_range_lines: int | None = setting(
        192, "[range lines] of a random crop; null: whole scenes; pix2pix: 256 of 286", low=32
    )
    learning_rate: float = setting(
        0.0005,
        "Adam; constant for half the steps, then linearly to zero; pix2pix: 2e-4, constant",
        low=0,
        above=True,
    )
    precision: str = setting(
        "bfloat16",
        "of the arithmetic; weights are float32 in both. bfloat16: float32 on a processor without "
        "AVX-512, where that is ten times faster",
        choices=("float32", "bfloat16"),
    )

    def __post_init__(self):
        super().__post_init__()
        sizes = (self.n_range_bins, self.n_range_lines)
        if self.method == "pix2pix" and any(not size or size % 2**self.depth for size in sizes):
            msg = (
                f"pix2pix: n_range_bins and n_range_lines must be multiples of 2**{self.depth}, "
                f"got {sizes[0]} and {sizes[1]}"
            )
            raise ValueError(msg)


CGAN = {
    "measured": CganSettings(),
    "paper": CganSettings(
        method="pix2pix",
        depth=8,
        n_range_bins=256,
        n_range_lines=256,
        learning_rate=2e-4,
        precision="float32",
    ),
}


@dataclass(frozen=True)
class TrackerSettings(Checked):
    """Network and training of the tracker.

    The defaults are the small recipe; `published_settings` gives the published one.
    """

    network: str = setting(
        "multi_scale",
        "multi_scale: network of the tracker paper, small recipe; pyramid: one whose fine stages "
        "also see coarse ones; published: multi_scale with copies of scenes, loss and updates as "
        "in its code",
        choices=("multi_scale", "pyramid", "published"),
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
    recipe = TrackerSettings(
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


TRACKER = {"small": TrackerSettings(), "published": published_settings()}
