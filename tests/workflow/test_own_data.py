"""The workflow on files of other flights: every source, worked examples, export and back."""

import dataclasses
import shutil
from copy import deepcopy

import formats
import numpy as np
import pandas as pd
import pytest
import xarray as xr
import yaml
from numpy.testing import assert_allclose
from refusals import refusal
from runs import (
    ROOT,
    SCHEMA,
    WRITTEN,
    refused,
    rules_planned,
    run_snakemake,
    settings,
    text_of,
)
from snakemake.utils import update_config
from toy_scenes import toy_scenes

from lib.configuration import filled
from lib.sources import check_lists, frame_files, own_pairs
from snowsim.io import SceneSet, export_pairs, read_frames
from snowsim.statistics import fit

EXAMPLES = sorted((ROOT / "config/examples").glob("*.yaml"))


def test_there_is_a_worked_example_for_every_source():
    sources = {yaml.safe_load(path.read_text())["source"] for path in EXAMPLES}
    assert sources | {"reference"} == set(SCHEMA["properties"]["source"]["enum"])


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_worked_examples_pass_the_schema(path):
    config = deepcopy(WRITTEN)
    update_config(config, yaml.safe_load(path.read_text()))
    filled(config)


def test_the_example_table_lacks_nothing_but_the_files():
    lines = formats.failures(lambda: read_frames(ROOT / "config/frames.tsv"), 5, 5)
    assert all("echogram: expected a file, found nothing at" in line for line in lines)


def write_own(folder, source, **own):
    """Configuration files of a tiny run on own data, `own` the settings of the import."""
    return settings(folder, yaml.safe_dump({"source": source, "import": own}))


def test_a_table_without_a_frame_for_statistics_stops_before_any_job(tmp_path):
    (tmp_path / "a").touch()
    (tmp_path / "frames.tsv").write_text(f"{formats.TABLE_HEADER}\n1\ta\ta\ttrain\n")
    configs = write_own(tmp_path, "nsidc", frames=str(tmp_path / "frames.tsv"))
    assert "role: expected at least one frame for statistics" in refused(tmp_path, configs)


def test_a_scene_in_two_lists_stops_before_any_job(tmp_path):
    (tmp_path / "data_1.png").touch()
    for name in ("train.lst", "test.lst"):
        (tmp_path / name).write_text("data_1.png\n")
    configs = write_own(tmp_path / "run", "png_pairs", pairs={"folder": str(tmp_path)})
    expected = "test.lst: expected scenes that are in no other list, found 1 in train.lst too"
    assert expected in refused(tmp_path / "run", configs)


def test_pairs_whose_spacing_the_configuration_contradicts_are_refused(tmp_path):
    scenes = [dataclasses.replace(scene, name=f"toy_{i}") for i, scene in enumerate(toy_scenes(2))]
    for scene in scenes:
        scene.notes["bin_size_s"] = 1.1e-10
    export_pairs(tmp_path, scenes)
    lists = {"train": tmp_path / "all.lst"}
    settings = {"contrast_db": 30.0}
    said = {"bin_size_s": ("import.bin_s", 2.886e-10), "line_spacing_m": ("a", 5.0)}
    with pytest.raises(
        ValueError, match="config: import.bin_s: expected 1.1e-10, as .*spacing.json"
    ):
        check_lists(lists, **settings, spacing=said)
    told = said | {"bin_size_s": ("import.bin_s", 1.1e-10)}
    assert len(check_lists(lists, **settings, spacing=told)) == 2


def test_spacing_is_read_beside_the_images_wherever_the_list_is(tmp_path):
    scenes = [dataclasses.replace(scene, name=f"toy_{i}") for i, scene in enumerate(toy_scenes(2))]
    for scene in scenes:
        scene.notes["bin_size_s"] = 1.1e-10
    export_pairs(tmp_path / "images", scenes)
    listed = [f"images/data_{scene.name}.png\n" for scene in scenes]
    (tmp_path / "train.lst").write_text("".join(listed))
    said = {"bin_size_s": ("import.bin_s", 2.886e-10), "line_spacing_m": ("a", 5.0)}
    message = "config: import.bin_s: expected 1.1e-10, as .*images/spacing.json says, got 2.886e-10"
    with refusal(message):
        check_lists({"train": tmp_path / "train.lst"}, contrast_db=30.0, spacing=said)
    pairs = own_pairs(tmp_path, {"train": "train.lst"})["train"]
    assert tmp_path / "images/spacing.json" in pairs.files(slice(0, 1))


def test_a_copy_of_a_train_scene_is_no_test_scene(tmp_path):
    scenes = [dataclasses.replace(scene, name=f"toy_{i}") for i, scene in enumerate(toy_scenes(3))]
    scenes[2].image = scenes[0].image
    export_pairs(tmp_path, scenes)
    (tmp_path / "train.lst").write_text("data_toy_0.png\ndata_toy_1.png\n")
    (tmp_path / "test.lst").write_text("data_toy_2.png\n")
    lists = {split: tmp_path / f"{split}.lst" for split in ("train", "test")}
    message = (
        "test: toy_2: expected an image that is in no other list, found that of toy_0 of train"
    )
    with refusal(message):
        check_lists(lists, contrast_db=30.0, spacing=None)


def test_all_files_of_a_store_and_flags_beside_it_are_inputs(tmp_path):
    store = tmp_path / "a.zarr"
    (store / "Data").mkdir(parents=True)
    (store / "Data/0.0").touch()
    (tmp_path / "a_supplement.nc").touch()
    row = {"echogram": str(store), "layers": ""}
    files = [store, store / "Data/0.0", tmp_path / "a_supplement.nc"]
    assert frame_files(row) == [str(file) for file in files]


def test_changed_flags_and_a_changed_setting_are_read_again_in_one_run(tmp_path, rng):
    formats.write_nsidc_flight(tmp_path, rng, ("statistics", "train", "test"), 512)
    own = {"source": "nsidc", "frames": str(tmp_path / "frames.tsv")}
    configs = write_own(tmp_path, **own)
    run_snakemake(tmp_path / "run", "--", "flight", configs=configs)

    def again():
        return rules_planned(tmp_path / "run", configs, ["flight"])[0]

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


@pytest.fixture(scope="module")
def exported(tiny_run, tmp_path_factory):
    """A copy of the finished tiny run with all its sets exported."""
    folder = tmp_path_factory.mktemp("exported") / "run"
    shutil.copytree(tiny_run, folder)
    run_snakemake(folder, "--rerun-triggers", "mtime", "--", "export")
    return folder / "results"


@pytest.mark.slow
def test_the_pipeline_runs_unchanged_on_a_folder_in_the_published_layout(exported, tmp_path):
    pairs = {"folder": str(exported / "export/pairs/rd"), "lists": {"validation": "validation.lst"}}
    configs = write_own(tmp_path, "png_pairs", pairs=pairs)
    done = run_snakemake(tmp_path, configs=configs, timeout=1800)
    assert "left out: figures of the flight and Doppler spectra: images hold" in text_of(done)
    results = tmp_path / "results"
    # Images and masks of train scenes are those of the reference run, so what never saw the
    # statistics learns the same. Renders did. Masks hold layers in whole rows, the reference run
    # fractions of them: trackers are calibrated to a little different layers.
    ours, theirs = (each / "tracker/rd/0_losses.csv" for each in (results, exported))
    assert ours.read_text() == theirs.read_text()
    ours, theirs = (pd.read_csv(each / "tables/table3.csv") for each in (results, exported))
    scores = ["rd_ods", "rd_ois", "rd_ap"]
    assert_allclose(ours[scores], theirs[scores], atol=0.02)
    assert ours.columns.equals(theirs.columns)
    assert ours.notna().all(axis=None)
    check_own(results)
    assert "source: png_pairs" in (results / "figures/labels.svg").read_text()
    changed = write_own(tmp_path, "png_pairs", pairs={**pairs, "contrast_db": 35.0})
    assert {"check_pairs", "import_pairs"} <= rules_planned(tmp_path, changed)[0]


@pytest.fixture
def tiny_flight(tiny_run):
    """Echogram and layers of every frame of the tiny flight."""
    paths = [tiny_run / f"results/flight/{number:04d}" for number in range(3)]
    return [(xr.load_dataset(f"{path}.nc"), xr.load_dataset(f"{path}_layers.nc")) for path in paths]


@pytest.fixture
def own_flight(tiny_flight, tmp_path):
    """Settings of a run on the tiny flight, which is written as files of NSIDC with a table."""
    # One frame has no pick of the first horizon: only names tell that its first layer is the
    # second one.
    n_layers = max(layers.sizes["layer"] for _, layers in tiny_flight)
    names = ["surface", *(f"Koenig_{number}" for number in range(1, n_layers))]
    ids = np.arange(n_layers)
    formats.write_mat5(tmp_path / formats.ORGANIZER_FILE, formats.organizer_content(ids, names))
    rows = []
    for number, role in enumerate(("statistics", "statistics", "test")):
        echogram, layers = tiny_flight[number]
        gps_time = formats.GPS_START + 60 * number + 0.05 * np.arange(echogram.sizes["slow_time"])
        formats.write_nsidc(tmp_path / f"{number}.nc", formats.content_of(echogram, gps_time))
        picks = f"Data_20120330_04_{number:03d}.mat"
        twtt = layers["twtt"].transpose("layer", "slow_time").values
        content = formats.layer_content(twtt, ids[: len(twtt)], gps_time)
        for key, name in {"lat": "Latitude", "lon": "Longitude", "elev": "Elevation"}.items():
            content[key] = echogram[name].values
        formats.write_mat5(tmp_path / picks, content)
        rows.append(f"frame_{number}\t{number}.nc\t{picks}\t{role}\n")
    rows.append(rows[0].replace("frame_0", "shown").replace("statistics", "train"))
    table = tmp_path / "frames.tsv"
    table.write_text("".join([f"{formats.TABLE_HEADER}\n", *rows]))
    own = {"frames": str(table), "description": "own frames", "layer_names": names}
    return write_own(tmp_path, "nsidc", **own)


@pytest.mark.slow
def test_own_files_give_the_flight_s_statistics_and_scenes(tiny_flight, tmp_path, own_flight):
    run_snakemake(tmp_path / "run", "--", "flight", "plot_flight", "labels", configs=own_flight)
    results = tmp_path / "run/results"
    expected, found = fit(tiny_flight[:2]), xr.load_dataset(results / "statistics.nc")
    assert found.attrs["synthetic"] == "no"
    # Decibels in float32, eps 6e-8 of some 30 dB, keep power to 4e-7; levelling by whole bins moves
    # nothing.
    for name in ("noise_power", "peak_power", "decay_rate", "thickness_mean_bins"):
        assert_allclose(found[name], expected[name], rtol=1e-5, err_msg=name)
    for split in ("train", "test"):
        # Lines 0 to 255 and 250 to 505 of 512.
        assert len(SceneSet(results / f"benchmark/{split}/0000.nc")) == 2
    check_own(results)
    assert "own frames" in (results / "figures/flight_line.svg").read_text()
