"""Command `snowsim scenes`."""

from pathlib import Path

import click


@click.command(short_help="Scenes to train a tracker on.", context_settings={"show_default": True})
@click.argument("folder", type=click.Path(file_okay=False, path_type=Path))
@click.option("-n", "n", type=click.IntRange(1), default=1500, help="Scenes.")
@click.option(
    "--statistics", type=click.Path(exists=True, dir_okay=False), help="Of a flight; the reference's if none."
)
@click.option("--format", "form", type=click.Choice(["pairs", "netcdf", "zarr"]), default="pairs")
@click.option("--range-lines", "n_range_lines", type=click.IntRange(2), default=256)
@click.option("--range-bins", "n_range_bins", type=click.IntRange(1), help="Of all; as layers need if not told.")
@click.option("--radiometry", type=click.Choice(["constant", "measured"]), default="measured")
@click.option("--looks", "n_looks", type=click.FloatRange(1), default=16, help="Averaged into a pixel.")
@click.option("--seed", type=click.IntRange(0), default=0)
def command(folder, n, statistics, form, seed, **settings):
    """Draw layers from the statistics of a flight, render them with PHY and write them to FOLDER: as image pairs in
    the published benchmark's layout, or as NetCDF or Zarr.

    \b
    Examples:
      snowsim scenes for_training/
      snowsim scenes few/ -n 20 --range-bins 512 --format netcdf --seed 1
      snowsim scenes mine/ --statistics results/statistics.nc
    """  # noqa: D205, D301
    from tqdm import tqdm

    from snowsim.front import scenes

    drawn = scenes(n, statistics=statistics or "reference", rng=seed, **settings)
    shown = tqdm(range(n), unit="scene", leave=False, disable=None)  # none where nobody looks
    counts = drawn.write(folder, form, indices=shown)
    click.echo(", ".join(f"{name} {count}" for name, count in counts.items()))
