"""Scores of a tracker's files.

The published layout, the reference's maps, every form of truth, planted errors.
"""

import json
import shutil

import formats
import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose
from PIL import Image
from refusals import refusal
from scipy.ndimage import binary_dilation

from snowsim import score_folders
from snowsim.cli import main
from snowsim.echogram import layer_mask
from snowsim.io import layer_numbers, write_dataset, write_image, write_layer_files
from snowsim.metrics.edges import THRESHOLDS, match_counts, score, suppress, thresholds_of

WAVE = np.round(6 * np.sin(np.arange(64) / 12))
LAYERS = 60.0 + 40 * np.arange(3)[:, None] + WAVE
N_BINS = 200
MASK = layer_mask(LAYERS, N_BINS)


def edge_map(offset_bins=0.0, layers=LAYERS):
    """Ridges of 8 bits about layers moved down by some bins."""
    away = np.arange(N_BINS)[:, None, None] - layers - offset_bins
    return np.rint(250 * np.exp(-((away / 2) ** 2)).max(axis=1)).astype(np.uint8)


def of_files(tmp_path, made, true, **options):
    """Scores of an array against another, and what is noted of them."""
    np.save(tmp_path / "made.npy", made)
    np.save(tmp_path / "true.npy", true)
    table = score_folders(tmp_path / "made.npy", tmp_path / "true.npy", n_bootstrap=1, **options)
    return table.loc[0, ["ods", "ap"]].tolist(), table.attrs["notes"]


@pytest.fixture
def folders(tmp_path):
    """Predictions as the published predictor leaves them, truth as the published benchmark does."""
    made, true = tmp_path / "made", tmp_path / "true"
    for number in range(3):
        name = f"20120429_01_{number:03d}.png"
        for output, offset in (("fuse", 1), ("side_1", 4), ("merge", 0)):
            write_image(made / output / f"data_{name}", edge_map(offset))
        write_image(true / f"layer_binary_{name}", MASK)
        write_image(true / f"data_{name}", edge_map())
    write_image(true / "layer_binary_20120429_01_999.png", MASK)  # a train scene: not predicted
    return made, true


def test_the_published_predictors_folder_is_scored_as_it_stands(folders, capsys):
    command = [*map(str, ["score", *folders]), "--matched-only", "--bootstrap", "20"]
    command += ["--thresholds", "published"]
    main([*command, "--format", "json"])
    printed = json.loads(capsys.readouterr().out)
    assert printed["notes"][0].startswith("scored are 3 of 4 truths")
    names = [row["image"] for row in printed["images"]]
    assert names == ["20120429_01_000", "20120429_01_001", "20120429_01_002"]
    counts = match_counts(suppress(edge_map(1) / 255), MASK, THRESHOLDS)
    chain = score([counts], THRESHOLDS)
    scores = {"ods": chain["ods"], "ap": chain["ap"], "share_within": 1, "n_missed_layers": 0}
    for name, value in (scores | {"n_false_layers": 0}).items():
        # JSON has ten decimals. Images that are all the same leave nothing to chance.
        assert_allclose([printed[row][name] for row in ("all", "low", "high")], value, atol=1e-10)
    main([*command, "--output", "side_1", "--format", "csv"])
    # 4 bins off: beyond 0.0075 diagonals of 210 pixels.
    assert "20120429_01_002,0,0," in capsys.readouterr().out


def as_file(folder, form, layers):
    """The same layers in a form that truth and picks may have."""
    path = folder / form
    mask = layer_mask(layers, N_BINS)
    numbers, _ = layer_numbers(layers, N_BINS)
    if path.suffix == ".nc":
        write_dataset(path, xr.Dataset({"layer_bins": (("range_line", "layer"), layers.T)}))
        return path
    values = {
        "layer_binary_x.png": mask,
        "x.png": mask,
        "layer_x.png": numbers,
        "mask.npy": mask,
        "grey.npy": 255 * mask.astype(np.uint8),
        "layers.npy": layers,
        "numbers.npy": numbers,
        "floats.npy": numbers.astype(float),
    }
    folder.mkdir(exist_ok=True)
    write = np.save if path.suffix == ".npy" else write_image
    write(path, values[form])
    return path


FORMS = [
    "layer_binary_x.png",
    "x.png",
    "layer_x.png",
    "scene_x.nc",
    "mask.npy",
    "grey.npy",
    "layers.npy",
    "numbers.npy",
    "floats.npy",
]


@pytest.mark.parametrize("form", FORMS)
def test_every_form_of_truth_and_picks_gives_the_same_scores(tmp_path, form):
    truth = as_file(tmp_path / "true", form, LAYERS)
    np.save(tmp_path / "x.npy", edge_map(1) / 255)
    table = score_folders(tmp_path / "x.npy", truth, n_bootstrap=1)
    edges = suppress(edge_map(1) / 255, added_curvature=0)
    expected = score([match_counts(edges, MASK, thresholds_of([edges]))])
    for name in ("ods", "ap"):
        assert_allclose(table.loc[0, name], expected[name], rtol=1e-12)
    made = as_file(tmp_path / "made", form, LAYERS + 3)
    folders = (made.parent, truth.parent)
    table = score_folders(*folders, picks=True, n_bootstrap=1, within_bins=2.9)
    errors = table.loc[0, ["mean_absolute_error_bins", "share_within", "share_found"]]
    assert errors.tolist() == [3, 0, 1]
    assert "ods" not in table


def test_the_image_beside_a_map_is_not_taken_for_it(folders):
    made, true = folders
    (made / "fuse").rename(true.with_name("maps"))
    write_image(true.with_name("maps") / "20120429_01_000.png", edge_map())
    table = score_folders(true.with_name("maps"), true, matched_only=True).set_index("image")
    # Beside it lies data_20120429_01_000.png, a bin too deep.
    assert table.loc["20120429_01_000", "mean_absolute_error_bins"] == 0


def saved(folder, made):
    """Folders of so many arrays, and of as many truths of the same layers."""
    folders = (folder / "made", folder / "true")
    for path, arrays in zip(folders, (made, [LAYERS] * len(made)), strict=True):
        path.mkdir()
        for number, values in enumerate(arrays):
            np.save(path / f"{number}.npy", values)
    return folders


def test_missed_and_false_layers_are_counted_in_the_set_and_in_resamples(tmp_path):
    folders = saved(tmp_path, [LAYERS, LAYERS[:2], np.vstack([LAYERS, LAYERS[-1] + 30])])
    table, again = (score_folders(*folders, picks=True, processes=n) for n in (1, 2))
    assert table.equals(again)
    counts = table.set_index("image")[["n_layers", "n_missed_layers", "n_false_layers"]]
    assert counts.loc[["1", "all"]].to_numpy().tolist() == [[3, 1, 0], [9, 1, 1]]
    # Binomial of 3 draws at 1/3: none with 8/27, three with 1/27 = 3.7 %, more than the 2.5 % above
    # the upper end.
    assert counts.loc[["low", "high"], "n_missed_layers"].tolist() == [0, 3]


@pytest.fixture
def ten(tmp_path):
    """Ten truths of the same layers, and a map of each, of which every second finds one layer."""
    return saved(tmp_path, [edge_map(1), edge_map(1, LAYERS[:1])] * 5)


@pytest.mark.parametrize("picks", [False, True])
def test_scores_do_not_rise_when_predictions_are_missing(ten, picks):
    made, true = ten
    if picks:
        made = true
    metric = "share_found" if picks else "ods"
    whole = score_folders(made, true, picks=picks, n_bootstrap=1).set_index("image")
    lacking = made.with_name("lacking")
    shutil.copytree(made, lacking)
    (lacking / "1.npy").unlink()
    found = score_folders(lacking, true, picks=picks, n_bootstrap=1)
    said = "truths without a prediction count as empty maps (1 of 10): 1"
    assert found.attrs["notes"] == [said]
    found = found.set_index("image")
    assert found.loc["1", [metric, "n_missed_layers"]].tolist() == [0, 3]
    assert found.loc["all", metric] < whole.loc["all", metric]


def test_scores_of_matched_pairs_alone_say_so_first(ten, capsys):
    (ten[0] / "1.npy").unlink()
    said = "scored are 9 of 10 truths, those with a prediction; left out: 1\n"
    for form in ("table", "csv"):
        main([*map(str, ["score", *ten]), "--matched-only", "--bootstrap", "1", "--format", form])
        out, err = capsys.readouterr()
        assert (err if form == "csv" else out).startswith(said)


def test_truth_without_a_layer_and_predictions_without_a_truth_are_named(ten):
    made, true = ten
    np.save(true / "1.npy", np.zeros((N_BINS, 64)))
    np.save(made / "extra.npy", edge_map(1))
    table = score_folders(made, true, n_bootstrap=1)
    assert table.attrs["notes"] == [
        "predictions without a truth are left out (1 of 11): extra",
        "in truths without a layer every prediction is false (1 of 10): 1",
    ]
    row = table.set_index("image").loc["1"]
    assert row[["ods", "n_layers", "n_missed_layers", "n_false_layers"]].tolist() == [0, 0, 0, 1]


def test_a_perfect_map_of_one_level_is_told_why_its_ap_is_0(tmp_path):
    scores, (note,) = of_files(tmp_path, MASK, MASK, suppressed=True)
    assert scores == [1, 0]
    assert note.startswith("ap is 0 because recall is the same at every threshold")


def test_truth_drawn_three_pixels_thick_scores_as_one_and_is_said_to_be_thinned(tmp_path):
    thin, notes = of_files(tmp_path, edge_map(1), MASK)
    assert notes == []
    thick, (note,) = of_files(tmp_path, edge_map(1), binary_dilation(MASK, np.ones((3, 1))))
    # It halved them: two thirds of the true pixels had no partner.
    assert thick == thin
    assert (
        note
        == "truths are thinned to the middle of layers drawn up to 3 pixels thick (1 of 1): made"
    )


def test_a_tenth_of_a_map_scores_as_the_map_without_a_word(tmp_path):
    noise = np.random.default_rng(1).uniform(0, 0.3, MASK.shape)
    whole = np.maximum(edge_map(1) / 255, noise)
    full, notes = of_files(tmp_path, whole, MASK)
    faint, of_faint = of_files(tmp_path, whole / 10, MASK)
    assert notes == of_faint == []
    # Values at the edge of suppression may round to the other side.
    assert_allclose(faint, full, atol=1e-4)


def test_grey_images_of_three_colours_or_16_bits_and_batches_of_one_score_as_the_map(tmp_path):
    grey = edge_map(1)
    forms = {"colours.png": np.dstack([grey] * 3), "bits.png": grey.astype(np.uint16) * 257}
    for name, values in forms.items():
        Image.fromarray(values).save(tmp_path / name)
    np.save(tmp_path / "batch.npy", grey[None])
    # Truth as people save it, too.
    Image.fromarray(np.dstack([255 * MASK.astype(np.uint8)] * 3)).save(tmp_path / "true.png")
    expected, _ = of_files(tmp_path, grey, MASK)
    for name in (*forms, "batch.npy"):
        found = score_folders(tmp_path / name, tmp_path / "true.png", n_bootstrap=1)
        assert found.loc[0, ["ods", "ap"]].tolist() == expected


BIN_S = 2e-10


@pytest.fixture
def layer_files(tmp_path):
    """Layers of an echogram, and the same a bin and a half deeper, as CReSIS and as NetCDF."""
    along = dict.fromkeys(("Latitude", "Longitude", "Elevation"), ("slow_time", WAVE))
    gps_time = formats.GPS_START + 0.04 * np.arange(WAVE.size)
    for name, off_bins in (("true", 0.0), ("made", 1.5)):
        layers = formats.opr_layers(3e-6 + (LAYERS + off_bins) * BIN_S, gps_time).assign(along)
        write_layer_files(tmp_path / name, "20120330_04", {1: layers})
        layers.to_netcdf(tmp_path / name / "frame_layers.nc")
    return tmp_path


def test_layer_files_are_scored_in_the_echogram_s_range_bins(layer_files):
    folders = [layer_files / name / "CSARP_layer/20120330_04" for name in ("made", "true")]
    Image.new("L", (3, 3)).save(folders[0] / "frame_picks.png")  # drawn by snowsim track --png
    for files in (folders, [layer_files / name / "frame_layers.nc" for name in ("made", "true")]):
        table = score_folders(*files, picks=True, bin_s=BIN_S, n_bootstrap=1)
        assert_allclose(table["mean_absolute_error_bins"][0], 1.5, rtol=1e-4)
    made, true = files
    with xr.open_dataset(true) as truth:
        peaks = truth["twtt"] + 1.5 * BIN_S
        truth.assign(peak_twtt=peaks).to_netcdf(true.with_name("simulated.nc"))
    # A simulated layer's echo peaks below it.
    table = score_folders(
        made, true.with_name("simulated.nc"), picks=True, bin_s=BIN_S, n_bootstrap=1
    )
    assert_allclose(table["mean_absolute_error_bins"][0], 0, atol=1e-9)
    with refusal("expected bin_s .--bin-s., the echogram's range bin"):
        score_folders(*folders, picks=True)
    np.save(layer_files / "rows.npy", LAYERS)
    with refusal("expected 64 range lines of an image .* found 64 .* with times"):
        score_folders(files[0], layer_files / "rows.npy", picks=True, bin_s=BIN_S)


@pytest.mark.parametrize(("name", "value"), [("tolerance", "a"), ("processes", True)])
def test_what_is_no_number_is_refused_by_name_before_anything_is_read(name, value):
    with refusal(f"{name} must be .* at least [01], got"):
        score_folders("nowhere", "nowhere", **{name: value})
