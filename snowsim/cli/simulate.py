"""Command `snowsim simulate`."""

from pathlib import Path

import click

# Written out: importing the radars takes a second, and help should not. A test compares them.
PRESETS = ("snow-2-8", "snow-2012", "snow-2-18", "ku-12-18", "accumulation")
POSITIVE = click.FloatRange(0, min_open=True)


@click.command(short_help="Echogram and layers of a radar over annual snow.", context_settings={"show_default": True})
@click.argument("echogram", type=click.Path(dir_okay=False, path_type=Path))
@click.option("--radar", type=click.Choice(PRESETS), default="snow-2-8")
@click.option("--centre-ghz", "centre_hz", type=POSITIVE, help="Of the sweep, in place of the radar's.")
@click.option("--bandwidth-ghz", "bandwidth_hz", type=POSITIVE, help="Of the sweep.")
@click.option("--bin-ns", "bin_s", type=POSITIVE, help="Two-way travel time of a range bin.")
@click.option("--window", help="Of the sweep, by its name in scipy.signal.")
@click.option("--height-m", type=POSITIVE, help="Antenna over the snow.")
@click.option("--beamwidth-deg", type=POSITIVE, help="Two-sided, 3 dB, of one antenna.")
@click.option("--looks", "n_looks", type=POSITIVE, help="Averaged into a range line.")
@click.option("--line-spacing-m", type=POSITIVE)
@click.option("--accumulation-m", type=POSITIVE, default=0.3, help="Of a year, in metres of water.")
@click.option("--variability", type=click.FloatRange(0), default=0.2, help="From year to year, of its logarithm.")
@click.option("--years", "n_years", type=click.IntRange(1), default=20, help="Annual layers.")
@click.option("--range-lines", "n_range_lines", type=click.IntRange(1), default=256)
@click.option("--seed", type=click.IntRange(0), default=0)
def command(echogram, radar, accumulation_m, variability, n_years, n_range_lines, seed, **changes):
    r"""Write the ECHOGRAM that a radar sees of annual layers of dry snow, an Open Polar Radar dataset (NetCDF), and
    its layers beside it, as NAME_layers.nc.

    \b
    Examples:
      snowsim simulate echogram.nc --radar ku-12-18 --accumulation-m 0.5
      snowsim simulate mine.nc --centre-ghz 5 --bandwidth-ghz 4 --bin-ns 0.2 --height-m 300
    """  # noqa: D205
    import numpy as np

    from snowsim.front import Climate, Radar, simulate
    from snowsim.io.files import write_dataset

    units = {"centre_hz": 1e9, "bandwidth_hz": 1e9, "bin_s": 1e-9}
    changes = {name: value * units[name] if name in units else value for name, value in changes.items() if value}
    snow = Climate(accumulation_m=accumulation_m, variability=variability, n_years=n_years)
    rng = np.random.default_rng(seed)
    found = simulate(snow, Radar.preset(radar, **changes), n_range_lines=n_range_lines, rng=rng)
    for path, dataset in zip((echogram, echogram.with_name(f"{echogram.stem}_layers.nc")), found, strict=True):
        write_dataset(path, dataset)
        click.echo(f"{path}: {', '.join(f'{size} {name}' for name, size in dataset.sizes.items())}")
