"""How PHY reads eq. (1): as closes the loop of the statistics, or as printed."""

from dataclasses import dataclass

from snowsim.settings import check_settings, setting


@dataclass(frozen=True)
class Settings:
    """Conventions of PHY; by the defaults, renders have the statistics that they are made from."""

    tolerance_db: float | None = setting(
        0.05,
        "[dB] error allowed in mean power of a pixel; null: exact; 100 looks scatter by 0.43 dB",
        exclusiveMinimum=0,
    )
    normalise: str = setting(
        "peak",
        "the convolved waveform peaks at the layer's power; none: as printed",
        enum=("peak", "none"),
    )
    align: str = setting(
        "peak",
        "the waveform's peak lies on the layer; gaussian: the Gaussian's",
        enum=("peak", "gaussian"),
    )
    width: str = setting(
        "fitted",
        "variance that fits the flight; paper: U(bounds of 1/e widths) used as a variance",
        enum=("fitted", "paper"),
    )
    width_bounds: tuple | None = setting(
        None,
        "[range bins] for width: paper; null: as measured in the flight; paper: [10, 15]",
        listed="two positive numbers",
        minItems=2,
        maxItems=2,
        exclusiveMinimum=0,
    )
    n_looks: float | None = setting(
        16,
        "[looks] as in the benchmark (benchmark.n_looks); paper: 100; null: as in the flight",
        minimum=1,
    )
    speckle: str = setting(
        "quantile",
        "law within 1e-5; gamma: exact; looks: eqs (3)-(4); "
        "correlated speckle is drawn by quantile instead of gamma, and not by looks",
        enum=("gamma", "looks", "quantile"),
    )
    speckle_correlation: str = setting(
        "measured",
        "down range, as in the flight's air; none: independent range bins, as printed",
        enum=("measured", "none"),
    )
    background: str = setting(
        "measured",
        "mean power of unpicked snow, below the surface; none: only layers, as printed. Label sets "
        "of measured radiometry have theirs in any case",
        enum=("measured", "none"),
    )

    def __post_init__(self):
        check_settings(self)


# Section III; 100 input lines make one line of its image. Here they lie within its 5.2 m, over
# which layers move by 0.2 bins: that would widen a variance of 10 by 0.003.
PAPER = Settings(
    normalise="none",
    align="gaussian",
    width="paper",
    width_bounds=(10, 15),
    n_looks=100,
    speckle="gamma",
    speckle_correlation="none",
    background="none",
)
RECIPES = {"measured": Settings(), "paper": PAPER}
