"""Command `snowsim score`."""

import json
from math import isnan
from pathlib import Path

import click

from snowsim.constants import OUTPUTS

FILE_OR_FOLDER = click.Path(exists=True, path_type=Path)
NOT_NEGATIVE, POSITIVE = click.FloatRange(0), click.FloatRange(0, min_open=True)


@click.command(short_help="Edge scores and errors of picks of a tracker.", context_settings={"show_default": True})
@click.argument("predictions", type=FILE_OR_FOLDER)
@click.argument("truth", type=FILE_OR_FOLDER)
@click.option("--output", type=click.Choice(OUTPUTS), help="Of the published predictor's folders; fuse if not told.")
@click.option("--picks", is_flag=True, help="Predictions are layers, not edge maps; they have no edge scores.")
@click.option("--no-suppress", "suppressed", is_flag=True, help="Maps are thin already.")
@click.option("--tolerance", type=NOT_NEGATIVE, default=0.0075, help="Of matches, as a share of the diagonal.")
@click.option("--tolerance-bins", type=NOT_NEGATIVE, help="Of matches, in pixels instead.")
@click.option("--max-distance-bins", type=POSITIVE, default=10.0, help="Of a pick from its layer.")
@click.option("--within-bins", type=NOT_NEGATIVE, default=2.0, help="Errors to count as small.")
@click.option("--bootstrap", "n_bootstrap", type=click.IntRange(1), default=1000, help="Resamples of the images.")
@click.option("--seed", type=click.IntRange(0), default=0, help="Of the resamples.")
@click.option("-j", "--processes", type=click.IntRange(1), default=1)
@click.option("--format", "form", type=click.Choice(["table", "csv", "json"]), default="table")
def command(predictions, truth, form, **settings):
    """Score the edge maps (or --picks) of a tracker in PREDICTIONS against TRUTH, two folders of PNG, NPY or NetCDF
    files: ODS, OIS, AP, mean absolute error of picks, share within 2 bins, missed and false layers, of every image
    and, with 95 % intervals by the bootstrap over images, of all.

    Maps are 8-bit or in [0, 1], bright on dark, and suppressed to ridges first. Truth is a mask, layer numbers, or
    layers in range bins. To data_NAME or NAME belongs layer_binary_NAME, layer_NAME, scene_NAME or NAME. The published
    predictor's folder is taken as it stands.

    \b
    Examples:
      snowsim score predictions/ test/
      snowsim score predictions/ test/ --output side_3 -j 4 --format csv > side_3.csv
      snowsim score --picks my_layers/ test/ --within-bins 1
      snowsim score map.npy layers.npy --tolerance-bins 3
    """  # noqa: D205, D301
    from tqdm import tqdm

    from snowsim.scoring import score_folders

    def progress(steps, total):
        return tqdm(steps, total=total, unit="image", leave=False, disable=None)  # none where nobody looks

    table = score_folders(predictions, truth, **settings, progress=progress)
    if form == "csv":
        click.echo(table.to_csv(index=False, float_format="%.10g", lineterminator="\n"), nl=False)
        return
    if form == "json":
        *images, found, low, high = json.loads(table.to_json(orient="records", double_precision=10))
        click.echo(
            json.dumps({"settings": settings, "all": found, "low": low, "high": high, "images": images}, indent=1)
        )
        return
    images, (_, found), (_, low), (_, high) = table.iloc[:-3], *table.iloc[-3:].iterrows()
    click.echo(images.to_string(index=False, na_rep="-", float_format="%.4g", max_rows=40))
    click.echo(f"\nall {len(images)} images")
    for name in table.columns[1:]:
        interval = "" if isnan(low[name]) else f" [{low[name]:.4g}, {high[name]:.4g}]"
        click.echo(f"  {name:<26} {found[name]:.4g}{interval}")
