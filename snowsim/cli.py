"""The command `snowsim`: each of its commands is a function here.

A function imports the modules that take long to load, so that help appears at once.
"""

import dataclasses
import gc
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
SHOW_DEFAULTS = {"show_default": True}
# Images of more range lines take tens of gigabytes to render.
MOST_RANGE_LINES = 2**16
FOUR_DIGITS = range(1000, 10_000)  # of a year
MOST_FRAMES = 999  # frames of a segment: their numbers have three digits
force_folder_option = click.option(
    "--force",
    is_flag=True,
    help="Write even if the folder is not empty; without it, such a folder is refused.",
)
force_files_option = click.option(
    "--force", is_flag=True, help="Replace files that exist; without it, they are refused."
)
density_option = click.option(
    "--density",
    help="Density of the snow [kg m-3], or the file of a measured profile; by default, density "
    "grows with depth from 340.",
)


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(__version__)
def commands():
    """Simulate Snow Radar echograms, track their layers and score trackers.

    The whole workflow runs with `make run`. An error is one line. Exit codes: 1, bad data or a full
    disk; 2, bad usage; 130, interrupted.
    """


@commands.command(short_help="Write scenes as image pairs.")
@click.argument("sources", nargs=-1, required=True, type=EXISTING)
@click.argument("folder", type=FOLDER)
@click.option(
    "--layers",
    type=EXISTING,
    help="File of the layers of the echogram, if the source is an echogram.",
)
@force_folder_option
def export(sources, folder, layers, force):
    """Write the scenes of SOURCES to FOLDER as image pairs, in the published benchmark's layout.

    SOURCES are scene sets, folders of image pairs, or one echogram with its --layers. An echogram
    is levelled and cut into blocks of 256 range lines.

    \b
    Examples:
      snowsim export results/phy/labels/*.nc for_training/
      snowsim export Data_20120429_01_001.mat --layers layer_20120429_01_001.mat my_scenes/
    """  # noqa: D205, D301
    from snowsim.io.frames import read_frame, scenes_of_frame
    from snowsim.io.pairs import check_empty, export_pairs, warn_of_others
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
    written = export_pairs(folder, with_progress(scenes, unit="scene"))
    with echo_warnings():
        warn_of_others(folder, written["n_scenes"])
    echo_counts(written)


def scene_set(source):
    """Scenes of a scene set, or of a folder of image pairs.

    An echogram is refused, with the advice to name its layers.
    """
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
            "if there is none, snowsim track picks them"
        )
        raise click.UsageError(msg) from error


@commands.command(short_help="Describe a file.")
@click.argument("file", type=EXISTING)
def info(file):
    """Print the format of FILE, its sizes, radar, time and place.

    FILE is an echogram (IRSNO1B, CReSIS L1B or Open Polar Radar), layers, scenes, statistics, an
    image, an array, or a folder of image pairs. For an echogram, the notes that `snowsim track`
    would give follow.

    \b
    Examples:
      snowsim info Data_20120429_01_001.mat
      snowsim info results/labels/0000.nc
    """  # noqa: D205, D301
    from snowsim.io.describe import describe
    from snowsim.io.files import noted

    with noted(file) as notes:
        lines, dataset = describe(file)
    for name, line in lines.items():
        click.echo(f"{name:<7} {line}")
    if dataset is not None and "Data" in dataset:
        notes += track_notes(file, dataset)
    for note in notes:
        click.echo(f"note    {note}")


def track_notes(path, echogram):
    """Notes on an echogram by the shipped tracker, or the reason why it refuses to track it."""
    from snowsim.io.models import read_tracker, shipped_trackers
    from snowsim.tracker import canonical, checked_card

    shipped = shipped_trackers()["universal"]
    _, card = read_tracker(shipped)
    try:
        return canonical(echogram, checked_card(card, shipped), str(path)).notes
    except ValueError as error:
        return [f"not tracked: {error}"]


@commands.command(short_help="Draw scenes to train a tracker on.", context_settings=SHOW_DEFAULTS)
@click.argument("folder", type=FOLDER)
@click.option("-n", "n", type=COUNT, default=1500, help="Number of scenes.")
@click.option(
    "--statistics",
    type=click.Path(exists=True, dir_okay=False),
    help="File of the statistics of a flight; by default, those of the reference flight.",
)
@click.option(
    "--range-lines",
    "n_range_lines",
    type=click.IntRange(2, MOST_RANGE_LINES),
    default=256,
    help="Number of range lines of a scene.",
)
@click.option(
    "--range-bins",
    "n_range_bins",
    type=COUNT,
    help="Number of range bins of a scene; by default, as many as its layers need.",
)
@click.option(
    "--recipe",
    type=click.Choice(["measured", "paper"]),
    default="measured",
    help="Draw layers as measured in the flight, or by the equations of the paper, which need "
    "--statistics of the estimator paper.",
)
@click.option(
    "--looks",
    "n_looks",
    type=click.FloatRange(1),
    default=16,
    help="Number of looks averaged into a pixel.",
)
@force_folder_option
@seed_option
def scenes(folder, n, statistics, force, seed, **settings):
    """Draw scenes from the statistics of a flight and write them to FOLDER as image pairs.

    Layers are drawn, PHY renders their echoes, and files are in the published benchmark's layout.

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
    short_help="Score a tracker's edge maps or picks.", context_settings=SHOW_DEFAULTS
)
@click.argument("predictions", type=EXISTING)
@click.argument("truth", type=EXISTING)
@click.option(
    "--picks",
    is_flag=True,
    help="Predictions are picked layers, not edge maps; they have no edge scores.",
)
@click.option(
    "--thresholds",
    type=click.Choice(["quantiles", "published"]),
    default="quantiles",
    help="Thresholds of the maps: quantiles of their values, or .01 to .99 as published.",
)
@click.option(
    "--no-suppress",
    "suppressed",
    is_flag=True,
    help="Do not suppress maps to ridges first, as they are thin already.",
)
@click.option(
    "--tolerance",
    type=NOT_NEGATIVE,
    default=0.0075,
    help="Largest distance between matched pixels, as a share of the image diagonal.",
)
@click.option(
    "--max-distance-bins",
    type=POSITIVE,
    default=10.0,
    help="Largest distance between a pick and its layer [range bins].",
)
@click.option(
    "--within-bins",
    type=NOT_NEGATIVE,
    default=2.0,
    help="Largest error of a pick that counts in share_within [range bins].",
)
@click.option(
    "--bin-s",
    type=POSITIVE,
    help="Length of a range bin of the echograms [s], two-way; needed for layer files only.",
)
@click.option(
    "--bootstrap",
    "n_bootstrap",
    type=COUNT,
    default=1000,
    help="Number of resamples of the images, from which the intervals come.",
)
@seed_option
@click.option(
    "-j", "--processes", type=COUNT, default=1, help="Number of processes that work at once."
)
@click.option(
    "--format",
    "form",
    type=click.Choice(["table", "csv", "json"]),
    default="table",
    help="Format of the printed scores.",
)
def score(predictions, truth, form, **settings):
    """Score the edge maps (or --picks) of a tracker in PREDICTIONS against TRUTH.

    Both are folders, or both are files. Scores are ODS, OIS, AP, mean absolute error of picks,
    share of picks within 2 bins, and numbers of missed and false layers. They are printed for every
    image, then for all images together with 95 % intervals (bootstrap over images).

    Maps are 8-bit grey PNG images or .npy files of floats in [0, 1], with bright layers; they are
    suppressed to ridges first. Truth is a mask or layer numbers (PNG, or .npy of whole numbers) or
    layers in range bins (.npy of floats). A missing prediction counts as an empty map. The truth of
    data_NAME or NAME is layer_binary_NAME, layer_NAME or NAME. With --picks, both may be layer
    files, such as those of `snowsim track` in CSARP_layer/SEGMENT.

    \b
    Examples:
      snowsim score predictions/ test/
      snowsim score predictions/fuse/ test/ -j 4 --format csv > fuse.csv
      snowsim score --picks my_layers/ test/ --within-bins 1
      snowsim score --picks picked/CSARP_layer/20120330_04 annotated/ --bin-s 2.886e-10
      snowsim score map.npy layers.npy --tolerance 0.01
    """  # noqa: D205, D301
    from snowsim.scoring import score_folders

    table = score_folders(predictions, truth, **settings)
    notes = table.attrs["notes"]
    if form != "json":
        # The CSV on stdout holds the table alone.
        click.echo("".join(f"{note}\n" for note in notes), nl=False, err=form == "csv")
    if form == "csv":
        click.echo(table.to_csv(index=False, float_format="%.10g", lineterminator="\n"), nl=False)
    elif form == "json":
        rows = json.loads(table.to_json(orient="records", double_precision=10))
        *images, all_images, low, high = rows
        scores = {"notes": notes, "settings": settings}
        scores |= {"all": all_images, "low": low, "high": high, "images": images}
        click.echo(json.dumps(scores, indent=1))
    else:
        echo_scores(table)


def echo_scores(table):
    """Print the scores of every image, then those of all images with their intervals."""
    images = table.iloc[:-3]
    all_images = table.iloc[-3]
    low = table.iloc[-2]
    high = table.iloc[-1]
    click.echo(images.to_string(index=False, na_rep="-", float_format="%.4g", max_rows=40))
    click.echo(f"\nall {len(images)} images")
    for name in table.columns[1:]:
        value = "-" if isnan(all_images[name]) else f"{all_images[name]:.4g}"
        interval = "" if isnan(low[name]) else f" [{low[name]:.4g}, {high[name]:.4g}]"
        click.echo(f"  {name:<26} {value}{interval}")


@commands.command(short_help="Train a tracker on scenes.", context_settings=SHOW_DEFAULTS)
@click.argument("sources", nargs=-1, required=True, type=EXISTING)
@click.option(
    "-o",
    "model",
    required=True,
    type=FILE,
    help="File of the trained network, NAME.onnx; its card is written to NAME.json.",
)
@click.option(
    "--from",
    "start",
    help="Tracker whose weights training starts from: universal, or an .onnx file that this "
    "command wrote; by default, random weights.",
)
@click.option(
    "--steps",
    "n_steps",
    type=COUNT,
    default=4000,
    help="Number of training steps, each on four crops.",
)
@click.option(
    "--bin-s",
    type=POSITIVE,
    help="Length of a range bin of the scenes [s], two-way; by default, as in their notes, else "
    "2.886e-10.",
)
@click.option(
    "--line-spacing-m",
    type=POSITIVE,
    help="Distance between range lines of the scenes [m]; by default, as in their notes, else 5.2.",
)
@click.option(
    "--device", type=click.Choice(["cpu", "cuda"]), default="cpu", help="Device to train on."
)
@force_files_option
@seed_option
def train(sources, model, n_steps, force, **settings):
    """Train a tracker on the scenes of SOURCES, which are scene sets or folders of image pairs.

    Every tenth scene is held out to calibrate probabilities: annotate these scenes fully. Needs the
    extra snowsim[learn].

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
    held_out = card["held_out"]
    result = "scenes held out: {n_scenes}, too few for a score"
    if "ods" in held_out:
        result = "fused ODS {ods:.3f} [{low:.3f}, {high:.3f}] on {n_scenes} scenes held out"
    click.echo(f"{model}: {result.format(**held_out)}")


@commands.command(short_help="Simulate an echogram and its layers.", context_settings=SHOW_DEFAULTS)
@click.argument("echogram", type=FILE)
@click.option(
    "--radar",
    type=click.Choice(PRESETS),
    default="snow-2-8",
    help="Radar to simulate, by its name in the package.",
)
@click.option(
    "--set",
    "changes",
    type=(str, str),
    multiple=True,
    help="Change one setting of the radar, by its name in snowsim.Radar; may be repeated.",
)
@click.option(
    "--profile",
    type=EXISTING,
    help="CSV file of a measured profile with columns depth_m and density_kg_m3; by default, "
    "annual layers are drawn from the climate.",
)
@click.option(
    "--accumulation-m",
    type=float,
    default=0.3,
    help="Mean annual accumulation [m w.e. / yr].",
)
@click.option(
    "--variability",
    type=float,
    default=0.2,
    help="Year-to-year standard deviation of the logarithm of accumulation.",
)
@click.option("--years", "n_years", type=int, default=20, help="Number of annual layers.")
@click.option(
    "--range-lines",
    "n_range_lines",
    type=COUNT,
    default=256,
    help="Number of range lines of an echogram.",
)
@click.option(
    "--frames",
    "n_frames",
    type=click.IntRange(1, MOST_FRAMES),
    default=1,
    help="Number of consecutive echograms to cut the simulation into; their names are numbered.",
)
@click.option(
    "--date",
    help="Day of the flight, YYYY-MM-DD; by default, the day in the file's name, else 2000-08-31.",
    show_default=False,
)
@force_files_option
@seed_option
@click.pass_context
def simulate(
    context, echogram, radar, changes, profile, n_range_lines, n_frames, date, force, seed,
    **climate,
):  # fmt: skip
    """Simulate a radar over annual layers of dry snow, or over a measured --profile, and write its
    ECHOGRAM and layers.

    An ECHOGRAM called NAME.nc is written as an Open Polar Radar dataset, its layers as
    NAME_layers.nc beside it. Data_YYYYMMDD_SS_FFF.mat is written as a CReSIS L1B file, its layers
    to the folder CSARP_layer. With --frames, snow, time and position continue from frame to frame.

    \b
    Examples:
      snowsim simulate echogram.nc --radar ku-12-18 --accumulation-m 0.5
      snowsim simulate echogram.nc --profile pit.csv
      snowsim simulate mine.nc --set centre_hz 5e9 --set bandwidth_hz 4e9 --set window blackman
      snowsim simulate Data_20120330_04_001.mat --frames 3
    """  # noqa: D205, D301
    from snowsim.io.files import written_together
    from snowsim.snowpack import Climate, Radar, simulate

    flight = {} if date is None else {"date": date}
    flight |= date_of_name(echogram, date)
    files = frame_files(echogram, n_frames)
    echogram_files, layer_files = zip(*files, strict=True)
    check_outputs([*echogram_files, *layer_files], force, ".nc", ".mat")
    if profile is not None:
        refuse_options(context, climate, "of a climate, not of a --profile")
    radar = Radar.preset(radar, **changes_of(Radar, changes))
    with echo_warnings():
        snow = Climate(**climate) if profile is None else measured_snow(profile)
        n_all = n_frames * n_range_lines
        simulated, layers = simulate(snow, radar, n_range_lines=n_all, rng=seed, **flight)
    written = []
    with written_together():
        for number, (path, path_to_layers) in enumerate(files):
            lines = slice(number * n_range_lines, (number + 1) * n_range_lines)
            # Layers come first: they are refused if the segment's layers have other names.
            written.append(write_frame(path_to_layers, layers.isel(slow_time=lines), path, number))
            written.append(write_frame(path, simulated.isel(slow_time=lines), path, number))
    click.echo("\n".join(written))


def date_of_name(path, date):
    """Date in a file's name, as an argument of `simulate`; empty if the name has none.

    UsageError if `date`, the one that the user asks for, is another.
    """
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
    """Pairs of the echogram file and the layer file of consecutive frames.

    A frame number in the name counts on from frame to frame. A name without one is numbered from 1
    on, if there are several frames.
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
    """Write the echogram or the layers of a frame, and return a line that says so.

    Segment and frame are those of the echogram's name. If the name has none, the segment is the
    simulation's; `number` counts its frames from 0.
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
    return f"{path}: {sizes}"


def changes_of(radar, changes):
    """Settings of a radar to change, as a dict of numbers and the name of a window.

    UsageError, with the names that exist, if a radar has no setting of a name.
    """
    names = [field.name for field in dataclasses.fields(radar)]
    values = {}
    for name, text in changes:
        if name not in names:
            msg = f"--set: a radar has no {name}, but {', '.join(sorted(names))}"
            raise click.UsageError(msg)
        try:
            values[name] = text if name == "window" else float(text)
        except ValueError:
            msg = f"--set {name}: expected a number, such as 4e9, got {text!r}"
            raise click.UsageError(msg) from None
    return values


def refuse_options(context, names, reason):
    """UsageError, with the reason, if one of these options is on the command line."""
    for name in names:
        if context.get_parameter_source(name) == click.core.ParameterSource.COMMANDLINE:
            option = next(o.opts[0] for o in context.command.params if o.name == name)
            msg = f"{option} is {reason}"
            raise click.UsageError(msg)


def measured_snow(path):
    """`Snowpack` of the profile in a file; prints the note on the profile."""
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
    """Context that prints each of its warnings once, in one line on stderr."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", UserWarning)
        yield
    for text in dict.fromkeys(str(warning.message) for warning in caught):
        click.echo(f"warning: {text}", err=True)


def check_outputs(paths, force, *endings):
    """UsageError if files cannot be written: the first that the user named, and others beside it.

    The first must have one of `endings` and lie in a folder that exists. No file may exist, unless
    `force` is true.
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


@commands.command(short_help="Pick the layers of echograms.", context_settings=SHOW_DEFAULTS)
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--output",
    "folder",
    # As text: an empty name would become the path of the present folder.
    type=click.Path(file_okay=False),
    required=True,
    help="Folder to write the layers to.",
)
@click.option(
    "--model",
    default="universal",
    help="Tracker: the name of one that comes with the package, or an ONNX file of snowsim train.",
)
@click.option("--png", is_flag=True, help="Also write a picture of every echogram with its picks.")
@click.option(
    "--bin-s",
    type=POSITIVE,
    help="Length of a range bin [s], two-way; needed for images only.",
)
@click.option(
    "--resume",
    is_flag=True,
    help="Go on with a run that was stopped: leave segments that were written from the same files "
    "by the same tracker.",
)
@click.option(
    "-j",
    "--processes",
    type=COUNT,
    default=1,
    help="Number of processes that work at once, each on a segment.",
)
@force_files_option
def track(files, folder, **options):
    """Pick the layers of FILES, echograms or images (PNG, JPEG), with a trained tracker.

    For each segment, CReSIS layer files are written to CSARP_layer/SEGMENT, and SEGMENT_layers.nc
    holds the layers of all its frames with the confidence of each pick. Those of an image are in
    NAME_layers.nc. Consecutive frames of a segment are tracked as one. The tracker was trained on
    synthetic scenes only.

    \b
    Examples:
      snowsim track Data_20120330_04_*.mat -o picked/
      snowsim track scene.png -o picked/ --bin-s 2.886e-10 --png
      snowsim track season/Data_*.mat -o picked/ -j 16 --resume
    """  # noqa: D205, D301
    gc.disable()  # imports leave nothing to collect, and looking for it takes a third of their time
    from snowsim.tracking import track_files

    gc.enable()
    gc.freeze()

    def echo_line(line):
        click.echo(line, err=line.startswith("error: "))

    if track_files(files, folder, say=echo_line, **options):
        sys.exit(1)


@commands.command(
    short_help="Date tracked layers, and compute accumulation.", context_settings=SHOW_DEFAULTS
)
@click.argument("files", nargs=-1, required=True, type=EXISTING)
@click.option(
    "-o",
    "--output",
    "path",
    required=True,
    type=FILE,
    help="File of the results: NAME.csv, NAME.nc or, with snowsim[gis], NAME.gpkg; means by year "
    "are written to NAME_years.csv beside it.",
)
@density_option
@click.option(
    "--temperature-k",
    type=float,
    help="Annual mean temperature of the firn [K]; density then grows with depth. By default, in "
    "Greenland, that of the position.",
)
@click.option(
    "--year",
    "years",
    multiple=True,
    help="Year of the first layer below the surface that is used (2011), or of a named layer "
    "(snow_3=2008, may be repeated). By default, years are counted from the last autumn before the "
    "flight.",
)
@click.option(
    "--annual/--count",
    default=None,
    help="Take every layer for one year, or count years. By default, every layer is a year if a "
    "person picked (picks have no confidence, and some are manual by their type), or if layers "
    "are those of snowsim simulate.",
)
@click.option(
    "--expected",
    "expected_m",
    type=float,
    help="Known accumulation of the place [m w.e. / yr]; by default, only the layers are used.",
)
@click.option(
    "--expected-error",
    type=float,
    default=0.3,
    help="Relative standard deviation of --expected.",
)
@click.option("--png", is_flag=True, help="Also draw layers and accumulation, as NAME.png.")
@click.option(
    "--echogram",
    "echograms",
    type=EXISTING,
    multiple=True,
    help="Echogram of a frame, drawn behind the layers in the picture; may be repeated.",
)
@force_files_option
def accumulation(files, path, density, years, png, echograms, force, **settings):
    """Compute depth, age and accumulation from the layers in FILES.

    FILES are the layers of one segment, which `snowsim track` wrote (SEGMENT_layers.nc), or layer
    files of its frames, which people picked. The result has a row for each range line and year.

    \b
    Columns of the CSV; NetCDF has them on (year, slow_time), GeoPackage has means over 500 m:
      year               year of the autumn in which a horizon formed; the snow of the twelve
                         months before lies below it
      depth_m            depth of that horizon, the upper end of the year's snow [m]
      thickness_m        thickness of the year's snow [m]
      accumulation_m_we  accumulation of the year [m w.e. / yr]
      low, high          limits of accumulation, which hold it in nine of ten cases
      year_confidence    probability that the year is right, with all doubt in layers above
      age_low, age_high  limits of the horizon's age in nine of ten cases [years]; 0: last autumn
      n_years            number of years between two picks, over which values are means
      flag               1 where the horizon at either end of the year is right with
                         less than .8, else 0
      open_m_we          snow above the horizon of the last autumn [m w.e.]

    \b
    Examples:
      snowsim accumulation picked/20120330_04_layers.nc -o accumulation.csv
      snowsim accumulation picked/*_layers.nc -o a.nc --year snow_3=2008 --density core.csv
      snowsim accumulation one_layers.nc -o a.gpkg --png --echogram one.nc
    """  # noqa: D205, D301
    from snowsim.io import open_segment, read_echogram
    from snowsim.io.files import write_dataset, write_table, written_together
    from snowsim.io.geopackage import write_lines
    from snowsim.io.pictures import write_picture
    from snowsim.snowpack import accumulation, by_year, pieces, table

    if settings["expected_m"] is None:
        refuse_options(
            click.get_current_context(), ("expected_error",), "of --expected, which is missing"
        )
    picture = path.with_suffix(".png")
    path_by_year = path.with_name(f"{path.stem}_years.csv")
    outputs = [path, path_by_year, picture] if png else [path, path_by_year]
    check_outputs(outputs, force, ".csv", ".nc", ".gpkg")
    with echo_warnings():
        layers = open_segment(files)
        found = accumulation(layers, density_of(density), year=year_of(years), **settings)
    rows = pieces(table(found)) if path.suffix == ".gpkg" else table(found)
    with written_together():
        if path.suffix == ".nc":
            write_dataset(path, found)
        elif path.suffix == ".gpkg":
            write_lines(path, rows)
        else:
            write_table(path, rows)
        write_table(path_by_year, by_year(found))
        if png:
            write_picture(picture, layers, [read_echogram(each) for each in echograms], found)
    echo_accumulation(path, len(rows), found, settings)
    if png:
        click.echo(f"{picture}: layers and accumulation")


def echo_accumulation(path, n_rows, found, settings):
    """Print the number of rows and years, the picks that were left out, and what was assumed."""
    summary = f"{n_rows} rows of {found.sizes['year']} years; uppermost horizon "
    summary += found.attrs["uppermost"]
    if found.attrs["no_horizon"]:
        summary += f"; left out as no horizons: {found.attrs['no_horizon']}"
    if found.attrs["n_below_profile"]:
        summary += f"; {found.attrs['n_below_profile']} picks below the end of the density left out"
    click.echo(f"{path}: {summary}")
    click.echo(found.attrs["surety"])
    if "temperature_k" in found.attrs:
        place = " of the place, by Fausto et al. (2009)" * (settings["temperature_k"] is None)
        click.echo(
            f"density: Herron & Langway (1980) from {found.attrs['surface_density_kg_m3']:g} "
            f"kg m-3, at {found.attrs['temperature_k']:.4g} K{place}"
        )
    if settings["annual"] is None and found.attrs["annual"]:
        click.echo(
            "every layer is taken for a year, as of a person or a simulation; --count counts years "
            "(picks of snowsim track have a confidence in SEGMENT_layers.nc)"
        )


@commands.command(
    short_help="Compare layers where tracks cross or overlap.", context_settings=SHOW_DEFAULTS
)
@click.argument("files", nargs=-1, required=True, type=EXISTING)
@click.option(
    "-o",
    "--output",
    "path",
    required=True,
    type=FILE,
    help="File of the results, NAME.csv or NAME.nc; figures by pair of segments are written to "
    "NAME_summary.csv beside it.",
)
@click.option(
    "--within-m",
    type=POSITIVE,
    default=50.0,
    help="Largest distance between range lines that see the same snow [m].",
)
@click.option(
    "--tolerance-years",
    type=click.FloatRange(0, 0.5, min_open=True),
    default=0.25,
    help="Largest difference in mass between matched layers [years of accumulation].",
)
@density_option
@click.option(
    "--temperature-k",
    type=float,
    help="Annual mean temperature of the firn [K]; by default, in Greenland, that of the position.",
)
@click.option(
    "--annual/--count",
    default=None,
    help="Take every layer for one year, or count years; by default, as snowsim accumulation does.",
)
@click.option(
    "--expected",
    "expected_m",
    type=float,
    help="Known accumulation of the place [m w.e. / yr]; by default, only the layers are used.",
)
@click.option("--png", is_flag=True, help="Also draw both profiles at each place, as NAME.png.")
@force_files_option
def agreement(files, path, within_m, tolerance_years, density, png, force, **dating):
    """Compare the layers in FILES where tracks cross, overlap or were flown twice.

    There the same snow was seen twice, so that picks and accumulation are scored without truth.
    FILES are layer files of several segments, or of one that crosses itself. Files whose names have
    the same segment (YYYYMMDD_SS) are joined; any other file is a segment of its own. A crossing
    has one row, an overlap one in every 20 times --within-m.

    \b
    Columns of the CSV; NetCDF has them on place, and every layer and year compared:
      first, second          names of both segments; differences are second less first
      meeting, kind          number of the crossing or overlap
      time_*, lat, lon       times of both range lines, position of the first
      distance_m, angle_deg  between both lines, and between both directions of flight
      length_m               length of track over which both are near each other [m]
      days_between           time between both flights [days]
      fallen_m_we            snow that fell in that time, taken off [m w.e.]
      n_first, n_second      layers of each, in snow that both have layers in
      n_matched              layers of both that are one, by the mass of snow above them
      share_matched          2 n_matched / (n_first + n_second)
      depth_*_m              rms and median difference of depth of matched layers [m]
      accumulation_*_m_we    the same of accumulation of years that both have [m w.e. / yr]
      offset_years           most frequent difference of years; not 0: one of both miscounted
      share_same_year        share of matched and dated layers of the same year

    \b
    Examples:
      snowsim agreement layers/*.nc -o agreement.csv
      snowsim agreement 2011/*_layers.nc 2012/*_layers.nc -o agreement.nc --png --within-m 100
    """  # noqa: D205, D301
    from snowsim.io import open_segments
    from snowsim.io.files import write_dataset, write_table, written_together
    from snowsim.io.place_pictures import write_places
    from snowsim.snowpack import agreement, agreement_summary, agreement_table

    picture = path.with_suffix(".png")
    path_of_summary = path.with_name(f"{path.stem}_summary.csv")
    outputs = [path, path_of_summary, picture] if png else [path, path_of_summary]
    check_outputs(outputs, force, ".csv", ".nc")
    with echo_warnings():
        found = agreement(
            open_segments(files),
            density_of(density),
            within_m=within_m,
            tolerance_years=tolerance_years,
            **dating,
        )
    summary = agreement_summary(found)
    with written_together():
        if path.suffix == ".nc":
            write_dataset(path, found)
        else:
            write_table(path, agreement_table(found))
        write_table(path_of_summary, summary)
        if png:
            write_places(picture, found)
    echo_agreement(path, summary)
    if png:
        click.echo(f"{picture}: layers at {found.sizes['place']} places")


def echo_agreement(path, summary):
    """Print how well all places together agree."""
    whole = summary.iloc[-1]
    click.echo(
        f"{path}: {whole['n_crossings']} crossings and {whole['n_overlaps']} overlaps of "
        f"{len(summary) - 1} pairs of segments, {whole['n_compared']} of {whole['n_places']} "
        "places compared"
    )
    if whole["n_compared"]:
        n_layers = whole["n_first"] + whole["n_second"]
        click.echo(f"{whole['share_matched']:.2f} of {n_layers} layers are matched")
    if whole["n_matched"]:
        click.echo(f"depth differs by {whole['depth_rms_m']:.2g} m (rms)")
    if not isnan(whole["accumulation_rms_m_we"]):
        rms_m = whole["accumulation_rms_m_we"]
        click.echo(f"accumulation of a year differs by {rms_m:.2g} m w.e. (rms)")
    if not isnan(whole["share_same_year"]):
        click.echo(
            f"years are offset at {whole['n_offset']} places, "
            f"{whole['share_same_year']:.2f} of matched and dated layers have the same year"
        )


def density_of(text):
    """Density of --density: a number [kg m-3], the profile in the file of that name, or None."""
    from snowsim.io.profiles import read_profile

    try:
        return None if text is None else float(text)
    except ValueError:
        profile = read_profile(text)
        click.echo(profile.note)
        return profile


def year_of(texts):
    """Year of the first horizon, or years of layers by name, from the texts of --year, or None."""
    if not texts:
        return None
    if len(texts) == 1 and "=" not in texts[0]:
        return calendar_year(texts[0])
    named = [text.partition("=") for text in texts]
    years = {name: year for name, _, year in named}
    if len(years) < len(texts) or "" in years.values():
        msg = f"--year: expected one year, or NAME=YEAR of layers that differ, got {texts}"
        raise click.UsageError(msg)
    return {name: calendar_year(year) for name, year in years.items()}


def calendar_year(text):
    """Year of four digits that an option states; 12 is none."""
    year = click.INT(text)
    if year not in FOUR_DIGITS:
        msg = f"--year: expected four digits, such as 2012, got {text}"
        raise click.UsageError(msg)
    return year


def echo_counts(counts):
    """Print counts by their names, in one line."""
    click.echo(", ".join(f"{name} {count}" for name, count in counts.items()))


def main(arguments=None):
    """Run a command. If it fails, print one line on stderr and exit with its code."""
    for stream in ("stdout", "stderr"):
        if getattr(sys, stream) is None:  # whoever started the command has closed it
            setattr(sys, stream, Path(os.devnull).open("w"))  # noqa: SIM115, open to the end
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
        except (
            OSError
        ):  # The disk is full: keep Python from writing, and failing, again at its end.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(code)
