"""Command `snowsim`, a function for each of its own; what takes time is imported when it runs."""

import dataclasses
import json
import os
import sys
import warnings
from contextlib import contextmanager
from itertools import chain
from math import isnan
from pathlib import Path
from types import SimpleNamespace

import click

from snowsim import __version__

EXISTING = click.Path(exists=True, path_type=Path)
FOLDER = click.Path(file_okay=False, path_type=Path)
FILE = click.Path(dir_okay=False, path_type=Path)
COUNT = click.IntRange(1)
NOT_NEGATIVE = click.FloatRange(0)
POSITIVE = click.FloatRange(0, min_open=True)
seed_option = click.option(
    "--seed", type=click.IntRange(0), default=0, help="Seed of the random numbers."
)
# Written out: importing the radars takes a second, and help should not.
PRESETS = ("snow-2-8", "snow-2012", "snow-2-18", "ku-12-18", "accumulation")
SHOWN = {"show_default": True}
# Images of more range lines take tens of gigabytes to render.
MOST_RANGE_LINES = 2**16
MOST_FRAMES = 999  # of a segment: their numbers have three digits
into_option = click.option("--force", is_flag=True, help="Write into a folder that is not empty.")
over_option = click.option("--force", is_flag=True, help="Write over files that are there.")


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(__version__)
def commands():
    """Simulate snow radar, and score what tracks its layers; the whole workflow is `make run`.

    Errors are one line; exit codes 1 bad data or no room, 2 bad usage, 130 interrupted.
    """


@commands.command(short_help="Scenes as image pairs, the published benchmark's layout.")
@click.argument("sources", nargs=-1, required=True, type=EXISTING)
@click.argument("folder", type=FOLDER)
@click.option(
    "--layers", type=EXISTING, help="Layers of the one source, an echogram: it is cut into scenes."
)
@into_option
def export(sources, folder, layers, force):
    """Write the scenes of SOURCES to FOLDER as image pairs: of scene sets, of folders of image
    pairs, or of one echogram with its --layers, which is levelled and cut into blocks of 256 range
    lines.

    \b
    Examples:
      snowsim export results/phy/labels/*.nc for_training/
      snowsim export Data_20120429_01_001.mat --layers layer_20120429_01_001.mat my_scenes/
    """  # noqa: D205, D301
    from snowsim.io.frames import read_frame, scenes_of_frame
    from snowsim.io.pairs import check_empty, export_pairs
    from snowsim.progress import with_progress

    if not force:
        check_empty(folder)
    if layers is None:
        scenes = chain.from_iterable(map(scene_set, sources))
    elif len(sources) > 1:
        msg = f"--layers are of one echogram, got {len(sources)}"
        raise click.UsageError(msg)
    else:
        row = SimpleNamespace(frame=sources[0].stem, echogram=sources[0], layers=layers)
        with echo_warnings():
            echogram, picked = read_frame(row)
        scenes, skipped = scenes_of_frame(row, echogram, picked)
        for name, reason in skipped.items():
            click.echo(f"{name} is no scene: {reason}", err=True)
    echo_counts(export_pairs(folder, with_progress(scenes, unit="scene")))


def scene_set(source):
    """Scenes of a scene set, or of a folder of image pairs; an echogram needs its layers."""
    from snowsim.io.containers import ECHOGRAMS, format_of, in_words, open_container
    from snowsim.io.files import is_zarr
    from snowsim.io.pairs import PairSet
    from snowsim.io.scenes import SceneSet

    if source.is_dir() and not is_zarr(source):
        return PairSet(source)
    try:
        return SceneSet(source)
    except ValueError as error:
        kind = format_of(open_container(source))
        if kind not in ECHOGRAMS:
            raise
        msg = (
            f"{source} is {in_words(kind)}: name the file of its layers, --layers FILE; "
            "where there are none, snowsim track picks them"
        )
        raise click.UsageError(msg) from error


@commands.command(short_help="What a file is, and what tracking would note.")
@click.argument("file", type=EXISTING)
def info(file):
    """Say what FILE is: an echogram (IRSNO1B, CReSIS L1B, Open Polar Radar), layers, scenes,
    statistics, an image or an array, or a folder of image pairs; its sizes, radar, time and place.
    For an echogram, print the notes that `snowsim track` would give.

    \b
    Examples:
      snowsim info Data_20120429_01_001.mat
      snowsim info results/labels/0000.nc
    """  # noqa: D205, D301
    from snowsim.io.describe import describe

    lines, held = describe(file)
    for what, line in lines.items():
        click.echo(f"{what:<7} {line}")
    for note in track_notes(file, held) if held is not None and "Data" in held else ():
        click.echo(f"note    {note}")


def track_notes(path, echogram):
    """Notes that tracking with the shipped tracker would give on an echogram; or its refusal."""
    from snowsim.io.models import read_tracker, shipped_trackers
    from snowsim.tracker import canonical, checked_card

    shipped = shipped_trackers()["universal"]
    _, card = read_tracker(shipped)
    try:
        return canonical(echogram, checked_card(card, shipped), str(path)).notes
    except ValueError as error:
        return [f"not tracked: {error}"]


@commands.command(short_help="Scenes to train a tracker on.", context_settings=SHOWN)
@click.argument("folder", type=FOLDER)
@click.option("-n", "n", type=COUNT, default=1500, help="Number of scenes.")
@click.option(
    "--statistics",
    type=click.Path(exists=True, dir_okay=False),
    help="Statistics of a flight; default: those of the reference flight.",
)
@click.option(
    "--range-lines",
    "n_range_lines",
    type=click.IntRange(2, MOST_RANGE_LINES),
    default=256,
    help="Range lines of a scene.",
)
@click.option(
    "--range-bins",
    "n_range_bins",
    type=COUNT,
    help="Range bins of a scene; default: as many as its layers need.",
)
@click.option(
    "--recipe",
    type=click.Choice(["measured", "paper"]),
    default="measured",
    help="Layers as in the flight, or as the paper prints them, which needs --statistics.",
)
@click.option(
    "--looks", "n_looks", type=click.FloatRange(1), default=16, help="Looks averaged into a pixel."
)
@into_option
@seed_option
def scenes(folder, n, statistics, force, seed, **settings):
    """Draw layers from the statistics of a flight, render them with PHY and write them to FOLDER
    as image pairs in the published benchmark's layout.

    \b
    Examples:
      snowsim scenes for_training/
      snowsim scenes few/ -n 20 --range-bins 512 --seed 1
      snowsim scenes mine/ --statistics results/statistics.nc
    """  # noqa: D205, D301
    from snowsim.front import scenes

    drawn = scenes(n, statistics=statistics or "reference", rng=seed, **settings)
    with echo_warnings():
        counts = drawn.write(folder, force=force)
    echo_counts(counts)


@commands.command(
    short_help="Edge scores and errors of picks of a tracker.", context_settings=SHOWN
)
@click.argument("predictions", type=EXISTING)
@click.argument("truth", type=EXISTING)
@click.option("--picks", is_flag=True, help="Predictions are layers, which have no edge scores.")
@click.option(
    "--thresholds",
    type=click.Choice(["quantiles", "published"]),
    default="quantiles",
    help="Thresholds: quantiles of the maps' values, or .01 to .99 as published.",
)
@click.option(
    "--no-suppress",
    "suppressed",
    is_flag=True,
    help="Maps are thin already: leave out suppression.",
)
@click.option(
    "--tolerance",
    type=NOT_NEGATIVE,
    default=0.0075,
    help="Largest distance of matched pixels, as a share of the image diagonal.",
)
@click.option(
    "--max-distance-bins",
    type=POSITIVE,
    default=10.0,
    help="Largest distance of a pick from its layer, in range bins.",
)
@click.option(
    "--within-bins",
    type=NOT_NEGATIVE,
    default=2.0,
    help="Largest error that counts in share_within, in range bins.",
)
@click.option(
    "--bin-s", type=POSITIVE, help="Range bin of the echograms in seconds; layer files need it."
)
@click.option(
    "--bootstrap",
    "n_bootstrap",
    type=COUNT,
    default=1000,
    help="Number of resamples of the images for the intervals.",
)
@seed_option
@click.option("-j", "--processes", type=COUNT, default=1)
@click.option("--format", "form", type=click.Choice(["table", "csv", "json"]), default="table")
def score(predictions, truth, form, **settings):
    """Score the edge maps (or --picks) of a tracker in PREDICTIONS against TRUTH, two folders or
    two files: ODS, OIS, AP, mean absolute error of picks, share within 2 bins, missed and false
    layers, of every image and, with 95 % intervals by the bootstrap over images, of all.

    Maps are 8-bit grey PNG images or .npy files of floats in [0, 1], bright on dark; they are
    suppressed to ridges first. Truth is a mask or layer numbers (PNG, or .npy of whole numbers) or
    layers in range bins (.npy of floats). A missing prediction counts as an empty map. The truth of
    data_NAME or NAME is layer_binary_NAME, layer_NAME or NAME. With --picks both may be layer
    files, such as `snowsim track` writes.

    \b
    Examples:
      snowsim score predictions/ test/
      snowsim score predictions/fuse/ test/ -j 4 --format csv > fuse.csv
      snowsim score --picks my_layers/ test/ --within-bins 1
      snowsim score --picks picked/ annotated/ --bin-s 2.886e-10
      snowsim score map.npy layers.npy --tolerance 0.01
    """  # noqa: D205, D301
    from snowsim.scoring import score_folders

    table = score_folders(predictions, truth, **settings)
    notes = table.attrs["notes"]
    if form != "json":
        # A table of numbers alone goes into files.
        click.echo("".join(f"{note}\n" for note in notes), nl=False, err=form == "csv")
    if form == "csv":
        click.echo(table.to_csv(index=False, float_format="%.10g", lineterminator="\n"), nl=False)
    elif form == "json":
        rows = json.loads(table.to_json(orient="records", double_precision=10))
        *images, found, low, high = rows
        scores = {"notes": notes, "settings": settings}
        scores |= {"all": found, "low": low, "high": high, "images": images}
        click.echo(json.dumps(scores, indent=1))
    else:
        echo_scores(table)


def echo_scores(table):
    """Show the scores of every image, then those of all with their intervals."""
    images = table.iloc[:-3]
    found = table.iloc[-3]
    low = table.iloc[-2]
    high = table.iloc[-1]
    click.echo(images.to_string(index=False, na_rep="-", float_format="%.4g", max_rows=40))
    click.echo(f"\nall {len(images)} images")
    for name in table.columns[1:]:
        value = "-" if isnan(found[name]) else f"{found[name]:.4g}"
        interval = "" if isnan(low[name]) else f" [{low[name]:.4g}, {high[name]:.4g}]"
        click.echo(f"  {name:<26} {value}{interval}")


@commands.command(short_help="A tracker of layers, trained on scenes.", context_settings=SHOWN)
@click.argument("sources", nargs=-1, required=True, type=EXISTING)
@click.option(
    "-o",
    "model",
    required=True,
    type=FILE,
    help="The network, NAME.onnx; its card is NAME.json.",
)
@click.option("--from", "start", help="universal, or an .onnx file of this command; else anew.")
@click.option("--steps", "n_steps", type=COUNT, default=4000, help="Gradients of four crops.")
@click.option(
    "--bin-s", type=POSITIVE, help="Range bin of the scenes; else as they tell, or 2.886e-10."
)
@click.option(
    "--line-spacing-m",
    type=POSITIVE,
    help="Distance of range lines of the scenes; else as they tell, or 5.2.",
)
@click.option("--device", type=click.Choice(["cpu", "cuda"]), default="cpu", help="Where to train.")
@over_option
@seed_option
def train(sources, model, n_steps, force, **settings):
    """Train a tracker on the scenes of SOURCES: scene sets, or folders of image pairs. Every tenth
    scene is held out, and probabilities are calibrated on it: annotate those fully. Needs the extra
    snowsim[learn].

    \b
    Examples:
      snowsim train my_pairs/ -o mine.onnx
      snowsim train results/phy/labels/*.nc -o mine.onnx --from universal --steps 1000
    """  # noqa: D205, D301
    check_outputs([model, model.with_suffix(".json")], force, ".onnx")
    try:
        from snowsim.learning import train_tracker
    except ModuleNotFoundError as error:
        msg = f"train needs {error.name}: pip install 'snowsim[learn]'"
        raise click.ClickException(msg) from error

    sets = [scene_set(source) for source in sources]
    with echo_warnings():
        card = train_tracker(model, sets, n_steps=n_steps, **settings)
    held = card["held_out"]
    told = "scenes held out: {n_scenes}, too few for a score"
    if "ods" in held:
        told = "fused ODS {ods:.3f} [{low:.3f}, {high:.3f}] on {n_scenes} scenes held out"
    click.echo(f"{model}: {told.format(**held)}")


@commands.command(
    short_help="Echogram and layers over annual snow or a profile.", context_settings=SHOWN
)
@click.argument("echogram", type=FILE)
@click.option(
    "--radar", type=click.Choice(PRESETS), default="snow-2-8", help="Radar of the package."
)
@click.option(
    "--set",
    "changes",
    type=(str, str),
    multiple=True,
    help="A number or the window of the radar, by its name in the API.",
)
@click.option(
    "--profile",
    type=EXISTING,
    help="CSV of a measured profile in place of a climate: depth_m and density_kg_m3.",
)
@click.option(
    "--accumulation-m", type=float, default=0.3, help="Snow of a year, in metres of water."
)
@click.option(
    "--variability",
    type=float,
    default=0.2,
    help="Standard deviation of its logarithm from year to year.",
)
@click.option("--years", "n_years", type=int, default=20, help="Number of annual layers.")
@click.option(
    "--range-lines",
    "n_range_lines",
    type=COUNT,
    default=256,
    help="Range lines of an echogram.",
)
@click.option(
    "--frames",
    "n_frames",
    type=click.IntRange(1, MOST_FRAMES),
    default=1,
    help="Consecutive echograms that one simulation is cut into, numbered in their names.",
)
@click.option(
    "--date",
    help="Day of the flight, YYYY-MM-DD; default: that of the name, else 2000-08-31.",
    show_default=False,
)
@over_option
@seed_option
@click.pass_context
def simulate(
    context, echogram, radar, changes, profile, n_range_lines, n_frames, date, force, seed,
    **climate,
):  # fmt: skip
    """Write the ECHOGRAM that a radar sees of annual layers of dry snow, or of a measured
    --profile, an Open Polar Radar dataset (NAME.nc), and its layers beside it, as NAME_layers.nc.
    Data_YYYYMMDD_SS_FFF.mat is written as a CReSIS L1B file, layers to CSARP_layer.
    With --frames snow, time and position go on from frame to frame.

    \b
    Examples:
      snowsim simulate echogram.nc --radar ku-12-18 --accumulation-m 0.5
      snowsim simulate echogram.nc --profile pit.csv
      snowsim simulate mine.nc --set centre_hz 5e9 --set bandwidth_hz 4e9 --set window blackman
      snowsim simulate Data_20120330_04_001.mat --frames 3
    """  # noqa: D205, D301
    from snowsim.snowpack import Climate, Radar, simulate

    flight = {} if date is None else {"date": date}
    flight |= date_of_name(echogram, date)
    files = frame_files(echogram, n_frames)
    echograms, beside = zip(*files, strict=True)
    check_outputs([*echograms, *beside], force, ".nc", ".mat")
    if profile is not None:
        refuse_options(context, climate, "of a climate, not of a --profile")
    radar = Radar.preset(radar, **changes_of(Radar, changes))
    with echo_warnings():
        snow = Climate(**climate) if profile is None else measured_snow(profile)
        n_all = n_frames * n_range_lines
        seen, layers = simulate(snow, radar, n_range_lines=n_all, rng=seed, **flight)
    for number, (path, path_to_layers) in enumerate(files):
        lines = slice(number * n_range_lines, (number + 1) * n_range_lines)
        # Layers first: others may be named beside them.
        write_frame(path_to_layers, layers.isel(slow_time=lines), path, number)
        write_frame(path, seen.isel(slow_time=lines), path, number)


def date_of_name(path, date):
    """The date that a file's name tells, as an argument of `simulate`; refused beside another."""
    from snowsim.echogram import named_frame

    segment, _ = named_frame(path)
    if segment is None:
        return {}
    day = segment.partition("_")[0]
    if date is not None and date.replace("-", "") != day:
        msg = f"{path}: the date of the name is not that of --date {date}"
        raise click.UsageError(msg)
    return {"date": day}


def frame_files(path, n_frames):
    """Echogram and layer file of consecutive frames.

    The number in a name goes on; another name gets one from 1 on, if there are several frames.
    """
    from snowsim.echogram import FRAME_IN_NAME

    named = FRAME_IN_NAME.search(path.stem)
    if path.suffix == ".mat" and named is None:
        msg = f"{path}: name it by segment and frame, Data_YYYYMMDD_SS_FFF.mat"
        raise click.UsageError(msg)
    before, first, after = f"{path.stem}_", 1, ""
    if named is not None:
        before, first, after = path.stem[: named.start(2)], int(named[2]), path.stem[named.end(2) :]
    if first + n_frames - 1 > MOST_FRAMES:
        msg = f"{path}: a segment has at most {MOST_FRAMES} frames, got --frames {n_frames}"
        raise click.UsageError(msg)
    frames = [path.with_stem(f"{before}{first + i:03d}{after}") for i in range(n_frames)]
    frames = [path] if n_frames == 1 else frames
    if path.suffix == ".mat":
        return [(frame, frame.parent / "CSARP_layer" / frame.name) for frame in frames]
    return [(frame, frame.with_name(f"{frame.stem}_layers.nc")) for frame in frames]


def write_frame(path, dataset, echogram, number):
    """Write a frame's echogram or layers; segment and frame are those of the echogram's name.

    Where it tells none, the segment is the simulation's, and `number` counts frames from 0.
    """
    from snowsim.echogram import named_frame
    from snowsim.io.files import write_dataset
    from snowsim.io.layers import write_cresis

    segment, frame = named_frame(echogram)
    if segment is None:
        segment, first = named_frame(dataset.granule)
        frame = first + number
    write = write_cresis if path.suffix == ".mat" else write_dataset
    write(path, dataset.assign_attrs(granule=f"{segment}_{frame:03d}"))
    sizes = ", ".join(f"{size} {name}" for name, size in dataset.sizes.items())
    click.echo(f"{path}: {sizes}")


def changes_of(radar, changes):
    """Numbers, and the window, to change of a radar; refused by names that it has."""
    names = [field.name for field in dataclasses.fields(radar)]
    found = {}
    for name, text in changes:
        if name not in names:
            msg = f"--set: a radar has no {name}, but {', '.join(sorted(names))}"
            raise click.UsageError(msg)
        found[name] = text if name == "window" else click.FLOAT(text)
    return found


def refuse_options(context, names, reason):
    """Refuse options that stand on the command line, with the reason."""
    for name in names:
        if context.get_parameter_source(name) == click.core.ParameterSource.COMMANDLINE:
            option = next(o.opts[0] for o in context.command.params if o.name == name)
            msg = f"{option} is {reason}"
            raise click.UsageError(msg)


def measured_snow(path):
    """`Snowpack` of a profile's file; what was read of it is shown."""
    from snowsim.io.profiles import read_profile
    from snowsim.snowpack import Snowpack

    profile = read_profile(path)
    click.echo(profile.note)
    try:
        return Snowpack.from_profile(
            profile.depth_m, profile.density_kg_m3, thickness_m=profile.thickness_m
        )
    except ValueError as error:
        msg = f"{path}: {error}"
        raise ValueError(msg) from error


@contextmanager
def echo_warnings():
    """Show each warning once, in one line on stderr."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", UserWarning)
        yield
    for text in dict.fromkeys(str(warning.message) for warning in caught):
        click.echo(f"warning: {text}", err=True)


def check_outputs(paths, force, *endings):
    """Refuse a first file of another ending or in no folder, and any, unless by force, over others.

    Names of further files are made of the first.
    """
    for path in paths:
        problem = None
        if path == paths[0] and path.suffix not in endings:
            problem = f"end the name of the file in {' or '.join(endings)}"
        elif path == paths[0] and not path.parent.is_dir():
            problem = f"there is no folder {path.parent}"
        elif path.exists() and not force:
            problem = "the file is there, --force writes over it"
        if problem is not None:
            msg = f"{path}: {problem}"
            raise click.UsageError(msg)


@commands.command(short_help="Layers of echograms, without any annotation.", context_settings=SHOWN)
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--output",
    "folder",
    type=click.Path(file_okay=False),  # as text: a path of no name would be the folder one is in
    required=True,
    help="Folder of the layers.",
)
@click.option("--model", default="universal", help="A tracker that is shipped, or its ONNX file.")
@click.option("--png", is_flag=True, help="Draw the picks on every echogram, too.")
@click.option("--bin-s", type=POSITIVE, help="Range bin of images [s], two-way; they tell none.")
@over_option
def track(files, folder, **options):
    """Pick the layers of FILES, echograms or images (PNG, JPEG), with a trained tracker: layer
    files as CReSIS has them, CSARP_layer/SEGMENT, and NAME_layers.nc with each pick's confidence.

    Frames of a segment that follow one another are tracked as one. The tracker was trained on
    synthetic scenes only.

    \b
    Examples:
      snowsim track Data_20120330_04_*.mat -o picked/
      snowsim track scene.png -o picked/ --bin-s 2.886e-10 --png
    """  # noqa: D205, D301
    from snowsim.tracking import track_files

    def say(line):
        click.echo(line, err=line.startswith("error: "))

    if track_files(files, folder, say=say, **options):
        sys.exit(1)


@commands.command(
    short_help="Depth, age and accumulation of tracked layers.", context_settings=SHOWN
)
@click.argument("files", nargs=-1, required=True, type=EXISTING)
@click.option(
    "-o",
    "--output",
    "path",
    required=True,
    type=FILE,
    help="NAME.csv, NAME.nc or, with snowsim[gis], NAME.gpkg; NAME_years.csv is written beside it.",
)
@click.option(
    "--density",
    help="Of the snow at every depth [kg m-3], or the file of a measured profile; by default it "
    "grows with depth, from 340.",
)
@click.option(
    "--temperature-k",
    type=float,
    help="Annual mean of firn, whose density grows with depth; in Greenland known by position.",
)
@click.option(
    "--year",
    "years",
    multiple=True,
    help="Of the first layer that is used, 2011, or of a layer, snow_3=2008; may be repeated. By "
    "default years are counted from the last autumn before the flight.",
)
@click.option(
    "--annual/--count",
    default=None,
    help="Every layer is one year, or years are counted; by default annual where no pick has a "
    "confidence, as a person's.",
)
@click.option(
    "--expected",
    "expected_m",
    type=float,
    help="Accumulation that is known of the place [m w.e. a year]; by default layers alone count.",
)
@click.option(
    "--expected-error",
    type=float,
    default=0.3,
    help="Relative standard deviation of --expected.",
)
@click.option("--png", is_flag=True, help="Draw layers and accumulation, too, as NAME.png.")
@click.option(
    "--echogram", "echograms", type=EXISTING, multiple=True, help="Of the frames, for the picture."
)
@over_option
def accumulation(files, path, density, years, png, echograms, force, **settings):
    """Tell depth, age and accumulation of the layers in FILES, frames of one segment as snowsim
    track writes them (NAME_layers.nc) or as people picked them: a row for each range line and year.

    \b
    Columns of the CSV; NetCDF has them on (year, slow_time), GeoPackage their means over 500 m:
      year               of a horizon; the snow of that year lies below it
      depth_m            of that horizon, the upper end of the year's snow
      thickness_m        of the year's snow
      accumulation_m_we  metres of water a year
      low, high          limits that hold it in nine of ten cases
      year_confidence    probability that year is right, with all doubt above
      age_low, age_high  limits of the years since then in nine of ten cases, 0 the last autumn
      n_years            between the picks that bound it; values are means over them
      flag               1 where year_confidence is below .8, else 0
      open_m_we          snow above the horizon of the last autumn

    \b
    Examples:
      snowsim accumulation picked/*_layers.nc -o accumulation.csv
      snowsim accumulation picked/*_layers.nc -o a.nc --year snow_3=2008 --density core.csv
      snowsim accumulation one_layers.nc -o a.gpkg --png --echogram one.nc
    """  # noqa: D205, D301
    from snowsim.io import open_segment, read_echogram
    from snowsim.io.files import write_dataset, write_table
    from snowsim.io.geopackage import write_lines
    from snowsim.io.pictures import write_picture
    from snowsim.snowpack import accumulation, by_year, pieces, table

    picture = path.with_suffix(".png")
    path_by_year = path.with_name(f"{path.stem}_years.csv")
    paths = [path, path_by_year, picture] if png else [path, path_by_year]
    check_outputs(paths, force, ".csv", ".nc", ".gpkg")
    with echo_warnings():
        layers = open_segment(files)
        found = accumulation(layers, density_of(density), year=year_of(years), **settings)
    rows = table(found)
    if path.suffix == ".nc":
        write_dataset(path, found)
    elif path.suffix == ".gpkg":
        rows = pieces(rows)
        write_lines(path, rows)
    else:
        write_table(path, rows)
    write_table(path_by_year, by_year(found))
    echo_accumulation(path, len(rows), found, settings["temperature_k"])
    if settings["annual"] is None and "confidence" not in layers:
        click.echo(
            "every layer is taken for a year, as a person's; --count counts years (of track's "
            "picks, NAME_layers.nc has the confidence)"
        )
    if png:
        write_picture(picture, layers, [read_echogram(each) for each in echograms], found)
        click.echo(f"{picture}: layers and accumulation")


def echo_accumulation(path, n_rows, found, temperature_k):
    """Show what was found, what was left out, and the density that was taken."""
    told = f"{n_rows} rows of {found.sizes['year']} years; uppermost horizon "
    told += found.attrs["uppermost"]
    if found.attrs["no_horizon"]:
        told += f"; left out as no horizons: {found.attrs['no_horizon']}"
    if found.attrs["n_below_profile"]:
        told += f"; {found.attrs['n_below_profile']} picks below the end of the density left out"
    click.echo(f"{path}: {told}")
    click.echo(found.attrs["surety"])
    if "temperature_k" in found.attrs:
        place = " of the place, by Fausto et al. (2009)" * (temperature_k is None)
        click.echo(
            f"density: Herron & Langway (1980) from {found.attrs['surface_density_kg_m3']:g} "
            f"kg m-3, at {found.attrs['temperature_k']:.4g} K{place}"
        )


def density_of(text):
    """Density that an option states [kg m-3], or the profile in the file of that name, or None."""
    from snowsim.io.profiles import read_profile

    try:
        return None if text is None else float(text)
    except ValueError:
        profile = read_profile(text)
        click.echo(profile.note)
        return profile


def year_of(texts):
    """Year of the first horizon, or of layers by name, as an option tells them; None if none."""
    if not texts:
        return None
    if len(texts) == 1 and "=" not in texts[0]:
        return click.INT(texts[0])
    named = [text.partition("=") for text in texts]
    years = {name: year for name, _, year in named}
    if len(years) < len(texts) or "" in years.values():
        msg = f"--year: expected one year, or NAME=YEAR of layers that differ, got {texts}"
        raise click.UsageError(msg)
    return {name: click.INT(year) for name, year in years.items()}


def echo_counts(counts):
    """Show how many of what were written."""
    click.echo(", ".join(f"{name} {count}" for name, count in counts.items()))


def main(arguments=None):
    """Run a command; where it fails, one line on stderr and its exit code."""
    try:
        commands.main(arguments, prog_name="snowsim", standalone_mode=False)
        sys.stdout.flush()
    except click.exceptions.NoArgsIsHelpError as error:
        error.show()
        sys.exit(2)
    except (click.ClickException, click.Abort, ValueError, OSError, MemoryError) as error:
        from snowsim.io.files import one_line

        message = error
        code = 1
        if isinstance(error, click.ClickException):
            message = error.format_message()
            code = 2
        elif isinstance(error, click.Abort):
            message = "interrupted"
            code = 130
        click.echo(f"error: {one_line(message)}", err=True)
        try:
            sys.stdout.flush()
        except OSError:  # a full disk: not to be tried again, and complained of, while Python ends
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(code)
