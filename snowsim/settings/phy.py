"""Looks of PHY's renders, by recipe: as measured in the flight, or as the paper prints them."""

from dataclasses import dataclass

from snowsim.settings import Checked, setting


@dataclass(frozen=True)
class Settings(Checked):
    """What may be chosen beside the recipe."""

    n_looks: float | None = setting(
        16,
        "[looks] as in the benchmark (benchmark.n_looks); paper: 100; null: as in the flight",
        low=1,
    )


# Section III; 100 input lines make one line of its image. Here they lie within its 5.2 m, over
# which layers move by 0.2 bins: that would widen a variance of 10 by 0.003.
PAPER = Settings(n_looks=100)
RECIPES = {"measured": Settings(), "paper": PAPER}
