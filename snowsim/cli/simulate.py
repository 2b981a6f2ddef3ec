"""Command `snowsim simulate`."""

from pathlib import Path

import click

# Written out: importing the radars takes a second, and help should not.
PRESETS = ("snow-2-8", "snow-2012", "snow-2-18", "ku-12-18", "accumulation")


@click.command(short_help="Echogram and layers of a radar over annual snow.", context_settings={"show_default": True})
@click.argument("echogram", type=click.Path(dir_okay=False, path_type=Path))
@click.option("--radar", type=click.Choice(PRESETS), default="snow-2-8")
@click.option(
    "--set", "changes", type=(str, float), multiple=True, help="A number of the radar, by its name in the API."
)
@click.option("--accumulation-m", type=float, default=0.3, help="Of a year, in metres of water.")
@click.option("--variability", type=float, default=0.2, help="From year to year, of its logarithm.")
@click.option("--years", "n_years", type=int, default=20, help="Annual layers.")
@click.option("--range-lines", "n_range_lines", type=click.IntRange(1), default=256)
@click.option("--seed", type=click.IntRange(0), default=0)
def command(echogram, radar, changes, n_range_lines, seed, **climate):
    """Write the ECHOGRAM that a radar sees of annual layers of dry snow, an Open Polar Radar dataset (NetCDF), and
    its layers beside it, as NAME_layers.nc.

    \b
    Examples:
      snowsim simulate echogram.nc --radar ku-12-18 --accumulation-m 0.5
      snowsim simulate mine.nc --set centre_hz 5e9 --set bandwidth_hz 4e9 --set bin_s 2e-10 --set height_m 300
    """  # noqa: D205, D301
    import numpy as np

    from snowsim.front import Climate, Radar, simulate
    from snowsim.io.files import write_dataset

    unknown = {name for name, _ in changes} - set(vars(Radar.preset(radar))) | {"window"} & dict(changes).keys()
    if unknown:
        msg = f"--set: a radar has no number {min(unknown)}"
        raise click.UsageError(msg)
    snow, radar = Climate(**climate), Radar.preset(radar, **dict(changes))
    found = simulate(snow, radar, n_range_lines=n_range_lines, rng=np.random.default_rng(seed))
    for path, dataset in zip((echogram, echogram.with_name(f"{echogram.stem}_layers.nc")), found, strict=True):
        write_dataset(path, dataset)
        click.echo(f"{path}: {', '.join(f'{size} {name}' for name, size in dataset.sizes.items())}")
