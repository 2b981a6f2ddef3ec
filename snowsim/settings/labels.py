"""What label sets take from the flight, and what the paper, section V-B, takes instead."""

from dataclasses import dataclass

from snowsim.settings import check_settings, setting


@dataclass(frozen=True)
class Settings:
    """How label sets are drawn; the defaults are as measured in the flight."""

    n_layers: str = setting(
        "measured",
        "below the surface: distributed as in the flight's zone; uniform: paper, U{5..40}",
        enum=("measured", "uniform"),
    )
    n_layers_min: int = setting(5, "[layers below the surface] of uniform, paper", minimum=1)
    n_layers_max: int = setting(40, "[layers below the surface] of uniform, paper", minimum=1)
    first_slab: str = setting(
        "measured",
        "mean thickness of slab 0: as in the flight's blocks; uniform: over their range, paper",
        enum=("measured", "uniform"),
    )
    surface: str = setting(
        "measured",
        "moves slowly and by the fraction of a bin left after levelling; flat: at bin 50, "
        "where the published benchmark has it; the paper names no bin",
        enum=("measured", "flat"),
    )
    radiometry: str = setting(
        "measured",
        "powers, noise, decay, texture as in the flight, visible layers; constant: paper",
        enum=("measured", "constant"),
    )
    correlation: str = setting(
        "measured",
        "between slabs: as in the flight; none: only through slab 0, paper",
        enum=("measured", "none"),
    )

    def __post_init__(self):
        check_settings(self)
        if self.n_layers_min > self.n_layers_max:
            msg = f"n_layers_min must be at most n_layers_max = {self.n_layers_max}, "
            msg += f"got {self.n_layers_min}"
            raise ValueError(msg)


PAPER = Settings(
    n_layers="uniform",
    first_slab="uniform",
    surface="flat",
    radiometry="constant",
    correlation="none",
)
RECIPES = {"measured": Settings(), "paper": PAPER}
