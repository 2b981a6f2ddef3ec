"""Settings of the conditional GAN, and its recipes: `paper` is pix2pix, Isola et al. (2017)."""

from dataclasses import dataclass

from snowsim.settings import Checked, setting


@dataclass(frozen=True)
class Settings(Checked):
    """Networks and training of the conditional GAN."""

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
            msg = f"pix2pix: n_range_bins and n_range_lines must be multiples of 2**{self.depth}, "
            msg += f"got {sizes[0]} and {sizes[1]}"
            raise ValueError(msg)


PAPER = Settings(
    method="pix2pix",
    depth=8,
    n_range_bins=256,
    n_range_lines=256,
    learning_rate=2e-4,
    precision="float32",
)
RECIPES = {"measured": Settings(), "paper": PAPER}
