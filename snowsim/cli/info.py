"""Command `snowsim info`."""

from pathlib import Path

import click


@click.command(short_help="What a file is: its axes, layers, and the traps found in it.")
@click.argument("file", type=click.Path(exists=True, path_type=Path))
def command(file):
    """Tell what FILE is: an echogram (IRSNO1B, CReSIS L1B, Open Polar Radar), layers, scenes, an image or an array, or
    a folder of image pairs; its axes and layers, and the traps found in it.

    \b
    Examples:
      snowsim info Data_20120429_01_001.mat
      snowsim info results/labels/0000.nc
    """  # noqa: D205, D301
    from snowsim.io.describe import describe

    for what, lines in describe(file).items():
        click.echo(f"{what:<7} " + ("\n" + 8 * " ").join(lines or ["none"]))
