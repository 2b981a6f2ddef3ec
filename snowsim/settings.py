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
    """Field of a setting: its default, its text `[unit] meaning, source`, and its limits.

    Limits of a number are those of `check_values`; those of a word are its `choices`.
    """
    return field(default=default, metadata={"about": about, "limits": limits})


class Checked:
    """Base of dataclasses of settings that are checked when an instance is made.

    ValueError, naming `group` and the setting, unless each value has the type of its field and is
    within its limits.
    """

    group = ""

    def __post_init__(self):
        for each in fields(self):
            _check(f"{self.group}{each.name}", getattr(self, each.name), each)


def _check(name, value, each):
    """ValueError unless a value has the type of its field and is within the limits of the field."""
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
    """Settings of PHY, apart from its recipe, which is either `measured` or `paper`."""

    n_looks: float | None = setting(
        16,
        "[looks] averaged in a pixel, as in the benchmark (benchmark.n_looks); paper: 100; null: "
        "as in the flight",
        low=1,
    )


# In section III of the paper, 100 input lines are averaged to one line of the image. Here these
# input lines lie within the 5.2 m of an image line. Over this distance layers move by 0.2 bins,
# which would widen a waveform of variance 10 by 0.003; this is neglected.
PHY = {"measured": PhySettings(), "paper": PhySettings(n_looks=100)}


@dataclass(frozen=True)
class CganSettings(Checked):
    """Networks and training of the conditional GAN; pix2pix follows Isola et al. (2017)."""

    method: str = setting(
        "measured",
        "measured: the networks see the depths of layers and the brightness that PHY expects of "
        "layers and snow; pix2pix: they see the mask alone, as in the paper",
        choices=("measured", "pix2pix"),
    )
    width: int = setting(16, "[channels] of the outermost stage; config/paper.yaml: 64", low=1)
    depth: int = setting(5, "[halvings] of the image in the generator; pix2pix: 8", low=2, high=10)
    n_steps: int = setting(
        2000, "[gradient steps] of the whole training; config/paper.yaml: 200 epochs", low=1
    )
    n_range_bins: int | None = setting(
        256,
        "[range bins] height of a random crop; null: whole scenes; pix2pix: 256, cut from scenes "
        "resized to 286",
        low=32,
    )
    n_range_lines: int | None = setting(
        192,
        "[range lines] width of a random crop; null: whole scenes; pix2pix: 256, cut from scenes "
        "resized to 286",
        low=32,
    )
    learning_rate: float = setting(
        0.0005,
        "of Adam; constant for half of the steps, then falls linearly to zero; pix2pix: 2e-4, "
        "constant",
        low=0,
        above=True,
    )
    precision: str = setting(
        "bfloat16",
        "precision of the arithmetic; weights are always float32. A processor without AVX-512 "
        "computes bfloat16 in float32, which is ten times faster there",
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
        "multi_scale: network of the tracker paper, trained by the small recipe; pyramid: network "
        "whose fine stages also see coarse ones; published: multi_scale, with the scene copies, "
        "loss and updates of the published code",
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
        192, "[range bins] height of a random crop; null: whole images", low=32
    )
    n_range_lines: int | None = setting(
        128, "[range lines] width of a random crop; null: whole images", low=32
    )
    flip: bool = setting(True, "also show images mirrored left to right")
    learning_rate: float = setting(
        0.001, "largest learning rate of the schedule", low=0, above=True
    )
    weight_decay: float = setting(0.01, "weight decay of the optimiser", low=0)
    layer_share: float | None = setting(
        0.03,
        "[1] share of layer pixels by which the loss balances layers and background; null: the "
        "share in each image, as published",
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
        "published: relative sizes at which an epoch shows every image",
        low=0,
        above=True,
        high=1,
    )
    n_accumulated: int = setting(
        10, "published: [gradients] added up for one update of the weights", low=1
    )
    n_steps_per_tenth: int = setting(
        10000, "published: [updates] after which the learning rate falls to a tenth", low=1
    )
    n_epochs_per_tenth: int | None = setting(
        None,
        "published: [epochs] after which the learning rate falls to a tenth, in place of "
        "n_steps_per_tenth; published code of 2020: 3",
        low=1,
    )

    def __post_init__(self):
        super().__post_init__()
        object.__setattr__(self, "scales", tuple(self.scales))

    @property
    def n_copies(self):
        """Number of times that an epoch shows each image."""
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
