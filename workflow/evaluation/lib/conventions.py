"""What the paper leaves open or contradicts itself about in eq. (1), as one choice of each."""

from dataclasses import asdict, dataclass


@dataclass(frozen=True)
class Convention:
    """How statistics are estimated, and how eq. (1) reads them."""

    estimator: str
    normalise: str
    align: str
    width: str

    @property
    def name(self):
        """Of files and rows of tables."""
        return "_".join(asdict(self).values())
