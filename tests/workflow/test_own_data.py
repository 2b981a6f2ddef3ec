"""The workflow on files of other flights: every source, worked examples, export and back."""

import shutil
from copy import deepcopy

import formats
import numpy as np
import own_files
import pandas as pd
import pytest
import xarray as xr
import yaml
from numpy.testing import assert_allclose, assert_array_equal
from runs import (
    ROOT,
    SCHEMA,
    WRITTEN,
    lines_with,
    refused,
    rules_to_run,
    run_snakemake,
    settings,
    text_of,
)
from snakemake.utils import update_config

from lib.configuration import filled
from snowsim.io.frame_table import read_frames
from snowsim.io.png_pairs import PairSet
from snowsim.io.scenes import SceneSet
from snowsim.statistics import fit

EXAMPLES = sorted((ROOT / "config/examples").glob("*.yaml"))
EXPORTED = {
    "rd": {split: f"benchmark/{split}" for split in ("train", "validation", "test")},
    "pd": {"train": "phy/labels"},
    "gd": {"train": "cgan/labels"},
}


def test_there_is_a_worked_example_for_every_source():
    sources = {yaml.safe_load(path.read_text())["source"] for path in EXAMPLES}
    assert sources | {"reference"} == set(SCHEMA["properties"]["source"]["enum"])


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_worked_examples_pass_the_schema_and_explain_every_setting(path):
    config = deepcopy(WRITTEN)
    update_config(config, yaml.safe_load(path.read_text()))
    filled(config)
    others = ("#", "source")
    lines = [line for line in path.read_text().splitlines() if not line.startswith(others)]
    lines = [line for line in lines if ": " in line]
    assert lines
    assert all("#" in line for line in lines)


def test_the_example_table_lacks_nothing_but_the_files():
    lines = formats.failures(lambda: read_frames(ROOT / "config/frames.tsv"), 5, 5)
    assert all("echogram: expected a file, found nothing at" in line for line in lines)


def write_own(folder, source, **own):
    """Configuration files of a tiny run on own data, `own` the settings of the import."""
    return settings(folder, yaml.safe_dump({"source": source, "import": own}))


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        (None, "frames.tsv: path: expected a file, found nothing"),
        ("\trole\n1\ta\tb\ttest\ttest\n", "found frame, echogram, layers, role, role.1"),
        ("\n1\ta\ta\ttrain\n", "role: expected at least one frame for statistics"),
    ],
    ids=["missing", "column twice", "role missing"],
)
def test_a_bad_table_stops_before_any_job(tmp_path, table, expected):
    if table is not None:
        (tmp_path / "frames.tsv").write_text(formats.TABLE_HEADER + table)
    (tmp_path / "a").touch()
    configs = write_own(tmp_path, "nsidc", frames=str(tmp_path / "frames.tsv"))
    assert expected in refused(tmp_path, configs)


def test_a_scene_in_two_lists_and_a_missing_folder_stop_before_any_job(tmp_path):
    (tmp_path / "data_1.png").touch()
    for name in ("train.lst", "test.lst"):
        (tmp_path / name).write_text("data_1.png\n")
    for folder, expected in (
        (tmp_path, "test.lst: expected scenes that are in no other list, found 1 in train.lst too"),
        (tmp_path / "none", "none/train.lst: path: expected a file, found nothing"),
    ):
        configs = write_own(tmp_path / "run", "png_pairs", pairs={"folder": str(folder)})
        assert expected in refused(tmp_path / "run", configs)


def test_changed_flags_and_a_changed_setting_are_read_again_in_one_run(tmp_path, rng):
    formats.write_nsidc_flight(tmp_path, rng, ("statistics", "train", "test"), 512)
    own = {"source": "nsidc", "frames": str(tmp_path / "frames.tsv")}
    configs = write_own(tmp_path, **own)
    run_snakemake(tmp_path / "run", "--", "flight", configs=configs)

    def again():
        plan = run_snakemake(tmp_path / "run", "--dry-run", "--", "flight", configs=configs)
        return rules_to_run(plan)

    assert again() == set()
    imports = {"check_frames", "import_frame", "import_blocks", "flight"}
    formats.write_supplement(tmp_path / "test_supplement.nc", low_SNR=1)
    assert again() == imports
    (tmp_path / "test_supplement.nc").unlink()
    assert again() == set()
    write_own(tmp_path, **own, flagged_by=["low_SNR"])
    assert again() == imports


def check_own(results):
    """No result says of itself that it is of the synthetic flight."""
    for ending in ("svg", "csv", "nc", "html"):
        for path in results.rglob(f"*.{ending}"):
            assert b"synthetic reference flight" not in path.read_bytes(), path


def check_statistics(found, expected, rtol):
    for name in ("noise_power", "peak_power", "decay_rate", "thickness_mean_bins"):
        assert_allclose(found[name], expected[name], rtol=rtol, err_msg=name)


@pytest.fixture(scope="module")
def exported(tiny_run, tmp_path_factory):
    """A copy of the finished tiny run with all its sets exported."""
    folder = tmp_path_factory.mktemp("exported") / "run"
    shutil.copytree(tiny_run, folder)
    run_snakemake(folder, "--rerun-triggers", "mtime", "--", "export")
    return folder / "results"


@pytest.mark.slow
@pytest.mark.parametrize("name", EXPORTED)
def test_exported_sets_are_those_of_the_run(exported, name):
    for part, folder in EXPORTED[name].items():
        scenes = SceneSet(sorted((exported / folder).glob("*.nc")))
        pairs = PairSet(exported / f"export/pairs/{name}/{part}.lst")
        assert pairs.names == [scene.name for scene in scenes]
        for found, scene in zip(pairs, scenes, strict=True):
            assert_array_equal(found.image, scene.image)
            assert_array_equal(found.mask(), scene.mask())
            dataset = xr.load_dataset(exported / f"export/netcdf/{name}/scene_{scene.name}.nc")
            assert_array_equal(dataset["image"], scene.image)
            assert_array_equal(dataset["layer_bins"], scene.layer_bins)
        about = (exported / f"export/pairs/{name}/about.txt").read_text()
        assert f"{part}.lst: n_scenes {len(scenes)}" in about


@pytest.mark.slow
def test_the_pipeline_runs_unchanged_on_a_folder_in_the_published_layout(exported, tmp_path):
    pairs = {"folder": str(exported / "export/pairs/rd"), "lists": {"validation": "validation.lst"}}
    configs = write_own(tmp_path, "png_pairs", pairs=pairs)
    done = run_snakemake(tmp_path, configs=configs, timeout=1800)
    assert "left out: figures of the flight and Doppler spectra: images hold" in text_of(done)
    results = tmp_path / "results"
    # Images and masks are those of the reference run, so what never saw the statistics scores the
    # same. Renders did.
    for table, same in {"table2": [], "table3": ["rd_ods", "rd_ois", "rd_ap"]}.items():
        ours = pd.read_csv(results / f"tables/{table}.csv")
        theirs = pd.read_csv(exported / f"tables/{table}.csv")
        assert list(ours.columns) == list(theirs.columns)
        assert len(ours) == len(theirs)
        numbers = ours.drop(columns=ours.columns[0]).select_dtypes("number")
        assert numbers.notna().all(axis=None)
        assert_allclose(ours[same], theirs[same], rtol=1e-9)
    assert (results / "report.html").is_file()
    check_own(results)
    assert "source: png_pairs" in (results / "figures/labels.svg").read_text()
    assert not (results / "figures/flight_line.svg").exists()
    changed = write_own(tmp_path, "png_pairs", pairs={**pairs, "data_scale": "db"})
    plan = run_snakemake(tmp_path, "--dry-run", configs=changed)
    assert {"check_pairs", "import_pairs"} <= rules_to_run(plan)


@pytest.fixture
def tiny_flight(tiny_run):
    """Echogram and layers of every frame of the tiny flight."""
    flight = tiny_run / "results/flight"

    def frame(number):
        echogram = xr.load_dataset(flight / f"{number:04d}.nc")
        layers = xr.load_dataset(flight / f"{number:04d}_layers.nc")
        return echogram, layers

    return [frame(number) for number in range(3)]


@pytest.fixture
def own_flight(tiny_flight, tmp_path):
    """A function that writes the tiny flight as files of a source, with a table; gives settings."""

    def write(source, kinds, old):
        rows = []
        roles_of_frames = (("statistics", "train"), ("statistics",), ("test",))
        for number, (kind, roles) in enumerate(zip(kinds, roles_of_frames, strict=True)):
            echogram, layers = tiny_flight[number]
            content = own_files.content_of(echogram, number * echogram.sizes["slow_time"])
            name = f"20120330_04_{number + 1:03d}"
            file = own_files.write_echogram(tmp_path, f"echogram_{number}", content, kind)
            picks = own_files.write_layers(tmp_path, name, layers, content, old=old)
            for role in roles:
                frame = f"{name}t" if role == "train" else name
                rows.append(f"{frame}\t{file.name}\t{picks.name}\t{role}\n")
        table = tmp_path / "frames.tsv"
        table.write_text("".join([f"{formats.TABLE_HEADER}\n", *rows]))
        own = {"frames": str(table), "description": "own frames"}
        # One frame has no pick of the first horizon: only names tell that its first layer is the
        # second one.
        n_layers = max(layers.sizes["layer"] for _, layers in tiny_flight)
        names = own_files.layer_names(n_layers)
        return write_own(tmp_path, source, **own, layer_names=names)

    return write


@pytest.mark.slow
@pytest.mark.parametrize(
    ("source", "kinds", "old"),
    [
        ("nsidc", ("nsidc", "nsidc", "nsidc"), False),
        ("cresis", ("mat73", "mat5", "mat73"), False),
        ("cresis", ("mat5", "mat73", "mat5"), True),
    ],
    ids=["nsidc", "cresis", "cresis old layers"],
)
def test_other_formats_give_the_flight_s_statistics_and_scenes(
    tiny_flight, tmp_path, own_flight, source, kinds, old
):
    configs = own_flight(source, kinds, old)
    run_snakemake(tmp_path / "run", "--", "flight", "charts", "labels", configs=configs)
    results = tmp_path / "run/results"
    expected, found = fit(tiny_flight[:2]), xr.load_dataset(results / "statistics.nc")
    assert found.attrs["synthetic"] == "no"
    assert found.sizes["layer"] == expected.sizes["layer"]
    # Decibels in float32, eps 6e-8 of some 30 dB, keep power to 4e-7; levelling by whole bins moves
    # nothing.
    check_statistics(found, expected, rtol=1e-5 if source == "nsidc" else 1e-12)
    for split in ("train", "test"):
        scenes = list(SceneSet(results / f"benchmark/{split}/0000.nc"))
        assert len(scenes) == 2  # lines 0 to 255 and 250 to 505 of 512
        for scene in scenes:
            assert_allclose(np.nanmedian(scene.layer_bins[0]), 50, atol=0.5)
            # The surface is bright where the layers say it is: nothing slipped against anything.
            surface = scene.layer_bins[0]
            rows = np.rint(surface).astype(int)
            lines = np.flatnonzero(np.isfinite(surface))
            on = scene.image[rows[lines], lines].mean()
            assert on > scene.image[rows[lines] - 12, lines].mean() + 50
    assert pd.read_csv(results / "tables/frames.csv")["n_scenes"].tolist() == [0, 2, 0, 2]
    check_own(results)
    assert "own frames" in (results / "figures/flight_line.svg").read_text()


@pytest.mark.slow
def test_range_lines_flagged_enter_neither_statistics_nor_scenes(tiny_flight, tmp_path, own_flight):
    configs = own_flight("nsidc", ("nsidc", "nsidc", "nsidc"), False)
    lines = np.arange(512)
    formats.write_supplement(
        tmp_path / "echogram_0_supplement.nc", no_good_data=np.uint8(lines < 60), land_ice=1
    )
    formats.write_supplement(
        tmp_path / "echogram_2_supplement.nc", missing_data=np.uint8(lines == 300), low_SNR=1
    )
    run_snakemake(tmp_path / "run", "--", "flight", "charts", configs=configs)
    results = tmp_path / "run/results"
    for dataset, name in zip(tiny_flight[0], ("Data", "twtt"), strict=True):
        dataset[name] = dataset[name].where(xr.DataArray(lines >= 60, dims="slow_time"))
    expected, found = fit(tiny_flight[:2]), xr.load_dataset(results / "statistics.nc")
    assert_array_equal(found["n_picks"], expected["n_picks"])
    check_statistics(found, expected, rtol=1e-5)  # decibels in float32, as above
    # Lines 0 to 255 and 250 to 505 of 512: one block of each is left.
    for split, first_line in (("train", 250), ("test", 0)):
        (scene,) = SceneSet(results / f"benchmark/{split}/0000.nc")
        assert scene.notes["first_line"] == first_line
    table = pd.read_csv(results / "tables/frames.csv", keep_default_na=False)
    assert table["n_flagged_lines"].tolist() == [60, 60, 0, 1]
    assert table["n_flagged_blocks"].tolist() == [0, 1, 0, 1]
    assert table["flags"].tolist() == [
        *2 * ["no_good_data 60; land_ice 512"],
        "",
        "missing_data 1; low_SNR 512",
    ]


@pytest.mark.slow
def test_frames_that_fail_are_all_named_in_one_go(tmp_path, own_flight):
    configs = own_flight("nsidc", ("nsidc", "mat5", "nsidc"), False)
    first = tmp_path / "echogram_0"
    first.write_bytes(first.read_bytes()[: first.stat().st_size // 2])
    done = run_snakemake(
        tmp_path / "run", "--", "results/statistics.nc", configs=configs, fails=True
    )
    assert "error: check_frames: frames: 3 of 4 frames fail" in text_of(done)
    for name in ("20120330_04_001: ", "20120330_04_001t: ", "20120330_04_002: "):
        assert lines_with(done, name)
    assert "found a CReSIS L1B echogram" in text_of(done)
    assert not (tmp_path / "run/results/flight").exists()
