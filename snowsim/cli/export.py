"""Command `snowsim export`."""

from pathlib import Path
from types import SimpleNamespace

import click

EXISTING = click.Path(exists=True, path_type=Path)


@click.command(short_help="Scenes in the published benchmark's layout, or as NetCDF.")
@click.argument("sources", nargs=-1, required=True, type=EXISTING)
@click.argument("folder", type=click.Path(file_okay=False, path_type=Path))
@click.option("--layers", type=EXISTING, help="Layers of the one source, an echogram: it is cut into scenes.")
@click.option("--netcdf", is_flag=True, help="Scenes as NetCDF, not image pairs.")
def command(sources, folder, layers, netcdf):
    """Write the scenes of SOURCES to FOLDER as image pairs: of scene sets, of folders of image pairs, or of one
    echogram with its --layers, which is levelled and cut into blocks of 256 range lines.

    \b
    Examples:
      snowsim export results/phy/labels/*.nc for_training/
      snowsim export Data_20120429_01_001.mat --layers layer_20120429_01_001.mat my_scenes/
      snowsim export my_scenes/ as_netcdf/ --netcdf
    """  # noqa: D205, D301
    from snowsim.io.export import export_netcdf, export_pairs
    from snowsim.io.frame_table import read_frame, scenes_of_frame
    from snowsim.io.png_pairs import PairSet
    from snowsim.io.scenes import SceneSet

    if layers is None:
        sets = [PairSet(source) if source.is_dir() else SceneSet(source) for source in sources]
        scenes = (scene for one in sets for scene in one)
    elif len(sources) > 1:
        msg = f"--layers are of one echogram, got {len(sources)}"
        raise click.UsageError(msg)
    else:
        row = SimpleNamespace(frame=sources[0].stem, echogram=sources[0], layers=layers)
        scenes, skipped = scenes_of_frame(row, *read_frame(row))
        for name, reason in skipped.items():
            click.echo(f"{name} is no scene: {reason}", err=True)
    counts = export_netcdf(folder, scenes) if netcdf else export_pairs(folder, scenes)
    click.echo(", ".join(f"{name} {count}" for name, count in counts.items()))
