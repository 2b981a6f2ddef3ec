"""Scores of a tracker's files.

Every form of map and truth, formats that are refused, planted errors.
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
from scipy.io import loadmat, savemat
from scipy.ndimage import binary_dilation, gaussian_filter

from snowsim import Climate, score_folders, simulate
from snowsim.cli import main
from snowsim.echogram import layer_mask
from snowsim.io import layer_numbers, write_image, write_layer_files
from snowsim.io.layers import write_cresis
from snowsim.metrics.edges import THRESHOLDS, match_counts, score, suppress, thresholds_of

WAVE = np.round(6 * np.sin(np.arange(64) / 12))
LAYERS = 60.0 + 40 * np.arange(3)[:, None] + WAVE
N_BINS = 200
MASK = layer_mask(LAYERS, N_BINS)


def edge_map(offset_bins=0.0, layers=LAYERS):
    """Ridges about layers moved down by some bins, in [0, 1], which 8 bits hold exactly.

    They fade along the track, so that there are many levels.
    """
    away = np.arange(N_BINS)[:, None, None] - layers - offset_bins
    fading = np.linspace(250, 200, layers.shape[1])
    return np.rint(fading * np.exp(-((away / 2) ** 2)).max(axis=1)) / 255


def write_map(path, probability):
    """Write an edge map as an 8-bit grey PNG image."""
    write_image(path, np.rint(255 * probability).astype(np.uint8))


def of_files(tmp_path, made, true, **options):
    """Scores of an array against another, and what is noted of them."""
    np.save(tmp_path / "made.npy", made)
    np.save(tmp_path / "true.npy", true)
    table = score_folders(tmp_path / "made.npy", tmp_path / "true.npy", n_bootstrap=1, **options)
    return table.loc[0, ["ods", "ap"]].tolist(), table.attrs["notes"]


@pytest.fixture
def folders(tmp_path):
    """Maps of three images, a bin too deep, and the published benchmark's images and labels."""
    made, true = tmp_path / "made", tmp_path / "true"
    for number in range(3):
        name = f"20120429_01_{number:03d}.png"
        write_map(made / f"data_{name}", edge_map(1))
        write_image(true / f"layer_binary_{name}", MASK)
        write_map(true / f"data_{name}", edge_map())
    return made, true


def test_the_command_prints_the_scores_of_every_image_and_of_all(folders, capsys):
    command = [*map(str, ["score", *folders]), "--bootstrap", "20", "--thresholds", "published"]
    main([*command, "--format", "json"])
    printed = json.loads(capsys.readouterr().out)
    assert printed["notes"] == []
    names = [row["image"] for row in printed["images"]]
    assert names == ["20120429_01_000", "20120429_01_001", "20120429_01_002"]
    counts = match_counts(suppress(edge_map(1)), MASK, THRESHOLDS)
    chain = score([counts], THRESHOLDS)
    scores = {"ods": chain["ods"], "ap": chain["ap"], "share_within": 1, "n_missed_layers": 0}
    for name, value in (scores | {"n_false_layers": 0}).items():
        # JSON has ten decimals. Images that are all the same leave nothing to chance.
        assert_allclose([printed[row][name] for row in ("all", "low", "high")], value, atol=1e-10)
    # 4 bins off: beyond 0.0075 diagonals of 210 pixels.
    write_map(folders[0] / "data_20120429_01_002.png", edge_map(4))
    main([*command, "--format", "csv"])
    assert "20120429_01_002,0,0," in capsys.readouterr().out


def as_file(folder, form, layers):
    """The same layers in a form that truth and picks may have."""
    path = folder / form
    mask = layer_mask(layers, N_BINS)
    numbers, _ = layer_numbers(layers, N_BINS)
    values = {
        "layer_binary_x.png": mask,
        "x.png": mask,
        "layer_x.png": numbers,
        "mask.npy": mask,
        "grey.npy": 255 * mask.astype(np.uint8),
        "layers.npy": layers,
        "numbers.npy": numbers,
    }
    folder.mkdir(exist_ok=True)
    write = np.save if path.suffix == ".npy" else write_image
    write(path, values[form])
    return path


FORMS = [
    "layer_binary_x.png",
    "x.png",
    "layer_x.png",
    "mask.npy",
    "grey.npy",
    "layers.npy",
    "numbers.npy",
]


@pytest.mark.parametrize("form", FORMS)
def test_every_form_of_truth_and_picks_gives_the_same_scores(tmp_path, form):
    truth = as_file(tmp_path / "true", form, LAYERS)
    np.save(tmp_path / "x.npy", edge_map(1))
    table = score_folders(tmp_path / "x.npy", truth, n_bootstrap=1)
    edges = suppress(edge_map(1), added_curvature=0)
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
    write_map(made / "20120429_01_000.png", edge_map(2))
    table = score_folders(made, true).set_index("image")
    # Beside it lies data_20120429_01_000.png, a bin too deep.
    assert table.loc["20120429_01_000", "mean_absolute_error_bins"] == 2
    assert table.loc["20120429_01_001", "mean_absolute_error_bins"] == 1


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


def test_truth_without_a_layer_and_predictions_without_a_truth_are_named(ten):
    made, true = ten
    np.save(true / "1.npy", np.zeros((N_BINS, 64), dtype=bool))
    np.save(made / "extra.npy", edge_map(1))
    table = score_folders(made, true, n_bootstrap=1)
    assert table.attrs["notes"] == [
        "predictions without a truth are left out (1 of 11): extra",
        "in truths without a layer every prediction is false (1 of 10): 1",
    ]
    row = table.set_index("image").loc["1"]
    assert row[["ods", "n_layers", "n_missed_layers", "n_false_layers"]].tolist() == [0, 0, 0, 1]


@pytest.mark.parametrize(
    ("n_levels", "gives_ap"), [(1, False), (4, False), (15, False), (16, True)]
)
def test_maps_with_fewer_than_16_levels_have_no_ap_and_a_note_says_why(
    tmp_path, n_levels, gives_ap
):
    noise = np.random.default_rng(1).uniform(0, 0.7, MASK.shape)
    made = np.maximum(edge_map(1), noise)
    floats, _ = of_files(tmp_path, made, MASK)
    made = np.rint(made / made.max() * n_levels) / n_levels
    scores, notes = of_files(tmp_path, made, MASK)
    assert scores[0] > 0.5
    if gives_ap:
        assert_allclose(scores[1], floats[1], atol=0.02)
        assert notes == []
    else:
        assert np.isnan(scores[1])
        assert notes == ["no ap of maps with fewer than 16 distinct values above 0 (1 of 1): made"]


def test_a_set_has_an_ap_if_only_one_map_of_it_has_few_levels(ten):
    np.save(ten[0] / "3.npy", np.rint(edge_map(1)))
    table = score_folders(*ten, n_bootstrap=1).set_index("image")
    assert table.index[table["ap"].isna()].tolist() == ["3"]
    # An empty map finds nothing: its ap is known.
    np.save(ten[0] / "3.npy", np.zeros(MASK.shape))
    assert score_folders(*ten, n_bootstrap=1)["ap"][3] == 0


def test_a_set_of_masks_shows_no_ap(ten, capsys):
    for path in ten[0].iterdir():
        np.save(path, MASK.astype(float))
    main([*map(str, ["score", *ten]), "--bootstrap", "2"])
    assert "  ap                         -\n" in capsys.readouterr().out


def test_8_bit_maps_among_maps_of_floats_are_noted(ten):
    (ten[0] / "3.npy").unlink()
    write_map(ten[0] / "3.png", edge_map(1))
    (note,) = score_folders(*ten, n_bootstrap=1).attrs["notes"]
    assert note.startswith("1 of 10 maps are 8-bit images, the others floats")


def test_an_ap_of_0_beside_a_good_f_is_explained(tmp_path):
    made = np.where(MASK, 0.995 + 1e-5 * np.arange(64), 0)  # above every published threshold
    scores, (note,) = of_files(tmp_path, made, MASK, suppressed=True, thresholds="published")
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


def test_layers_of_the_truth_outside_the_map_are_noted(tmp_path):
    inside, notes = of_files(tmp_path, edge_map(1), LAYERS)
    assert notes == []
    below = np.vstack([LAYERS, LAYERS[-1:] + 100])
    cut, (note,) = of_files(tmp_path, edge_map(1), below)
    assert cut == inside
    assert note.startswith("layers of truths leave the rows of their maps, and edge scores do not")


def test_a_map_a_thousand_times_fainter_scores_as_the_map_without_a_word(tmp_path):
    noise = np.random.default_rng(1).uniform(0, 0.3, MASK.shape)
    whole = np.maximum(edge_map(1), noise)
    full, notes = of_files(tmp_path, whole, MASK)
    faint, of_faint = of_files(tmp_path, whole / 1024, MASK)
    assert notes == of_faint == []
    # A power of two rounds nothing.
    assert faint == full


def test_batches_of_one_score_as_the_map(tmp_path):
    expected, _ = of_files(tmp_path, edge_map(1), MASK)
    found, _ = of_files(tmp_path, edge_map(1)[None, None], MASK)
    assert found == expected


def grey_levels(probability, *, form):
    """A picture of a form that is no 8-bit grey image."""
    levels = np.rint(255 * probability).astype(np.uint8)
    if form == "16 bits":
        return Image.fromarray(levels.astype(np.uint16) * 257)
    if form == "colours":
        return Image.fromarray(np.dstack([levels] * 3))
    return Image.fromarray(levels).convert({"alpha": "LA", "palette": "P"}[form])


@pytest.mark.parametrize("form", ["16 bits", "colours", "alpha", "palette"])
def test_pictures_that_are_no_8_bit_grey_are_refused_as_map_and_as_truth(tmp_path, form):
    grey_levels(edge_map(1), form=form).save(tmp_path / "picture.png")
    write_image(tmp_path / "grey.png", MASK)
    write_map(tmp_path / "map.png", edge_map(1))
    with refusal("picture.png: image: expected 8-bit grey, found mode"):
        score_folders(tmp_path / "picture.png", tmp_path / "grey.png")
    with refusal("picture.png: image: expected grey of 1 or 8 bits, found mode"):
        score_folders(tmp_path / "map.png", tmp_path / "picture.png")


def test_other_formats_are_refused_by_name(tmp_path, folders):
    made, true = folders
    Image.fromarray(np.zeros((N_BINS, 64), np.uint8)).save(tmp_path / "x.jpg")
    (tmp_path / "x.jpg").rename(tmp_path / "jpeg.png")
    (tmp_path / "x.nc").touch()
    mask = true / "layer_binary_20120429_01_000.png"
    for name, found in (("jpeg.png", "PNG, found JPEG"), ("x.nc", r"\.png or \.npy, found \.nc")):
        with refusal(f"{name}: format: expected {found}"):
            score_folders(tmp_path / name, mask)
        with refusal(f"{name}: format: expected {found}"):
            score_folders(tmp_path / name, mask, picks=name == "jpeg.png")
    # In a folder: a file with the name of a pair. Others, such as lists of files, do not matter.
    (true / "all.lst").touch()
    (made / "20120429_01_001.txt").touch()
    assert len(score_folders(made, true, n_bootstrap=1)) == 6
    (made / "data_20120429_01_001.png").rename(made / "data_20120429_01_001.tif")
    (made / "20120429_01_001.txt").unlink()
    with refusal("data_20120429_01_001.tif: format: expected .png or .npy, found .tif"):
        score_folders(made, true)


@pytest.mark.parametrize(
    ("made", "true", "message"),
    [
        (MASK, MASK, "made.npy: map: expected floats in .0, 1., or an 8-bit PNG image, found bool"),
        (edge_map(), MASK.astype(float), "true.npy: labels: expected whole numbers"),
        (edge_map(), LAYERS.astype(int), "range bins: floats., found 54 to 146"),
    ],
)
def test_the_type_of_an_array_says_what_it_holds(tmp_path, made, true, message):
    with refusal(message):
        of_files(tmp_path, made, true)


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
    with refusal(r"bin_s \[s\] must be .*, at most 1e-06, got 0.2886"):  # nanoseconds
        score_folders(*folders, picks=True, bin_s=0.2886)
    np.save(layer_files / "rows.npy", LAYERS)
    with refusal("expected 64 range lines of an image .* found 64 .* with times"):
        score_folders(files[0], layer_files / "rows.npy", picks=True, bin_s=BIN_S)


def test_interfaces_are_compared_with_interfaces_and_peaks_with_peaks_or_not_at_all(tmp_path):
    _, layers = simulate(Climate(accumulation_m=0.4), "snow-2012", n_range_lines=32, rng=1)
    write_cresis(tmp_path / "Data_20120330_04_001.mat", layers)
    forms = {
        "picked": layers.assign(twtt=layers["peak_twtt"]),
        "interfaces": layers,
        # The same without a word: as people pick, where echoes are largest.
        "unsaid": layers.assign(twtt=layers["peak_twtt"].assign_attrs(place=None)),
    }
    for name, held in forms.items():
        held["twtt"].attrs = {k: v for k, v in held["twtt"].attrs.items() if v is not None}
        held.drop_vars("peak_twtt").to_netcdf(tmp_path / f"{name}.nc")
    layers.to_netcdf(tmp_path / "both.nc")

    def bias_bins(made, true):
        pair = tmp_path / made, tmp_path / true
        table = score_folders(*pair, picks=True, bin_s=2.886e-10, n_bootstrap=1)
        return table["bias_bins"][0]

    truth = "Data_20120330_04_001.mat"
    pairs = [("picked.nc", truth), ("unsaid.nc", truth), ("interfaces.nc", truth)]
    for pair in [*pairs, ("picked.nc", "both.nc"), ("picked.nc", "unsaid.nc")]:
        assert_allclose(bias_bins(*pair), 0, atol=1e-6)
    with refusal("interfaces.nc: twtt: expected peaks of echoes, .* found interfaces alone"):
        bias_bins("interfaces.nc", "picked.nc")
    with refusal("picked.nc: twtt: expected interfaces alone, as .*interfaces.nc has, or both"):
        bias_bins("picked.nc", "interfaces.nc")
    # Files of snowsim 0.5.0 hold interfaces; only their organizer says so.
    content = loadmat(tmp_path / truth)
    kept = {name: content[name] for name in content if name[0] not in "_p"}
    savemat(tmp_path / truth, kept)
    with refusal("picked.nc: twtt: expected interfaces alone"):
        bias_bins("picked.nc", truth)


@pytest.mark.parametrize("scaled", [False, True])
def test_the_image_beside_the_truth_is_no_prediction(tmp_path, folders, scaled):
    _, true = folders
    image = np.random.default_rng(1).gamma(5, size=MASK.shape) + 10 * edge_map()
    image /= image.max()
    for path in true.glob("data_*.png"):
        write_map(path, image)
    made = true
    if scaled:
        made = tmp_path / "scaled"
        made.mkdir()
        for path in true.glob("data_*.png"):
            np.save(made / f"{path.stem}.npy", (image - image.min()) / np.ptp(image))
    with refusal(r"map: expected what a tracker made of an image, found the image .*/true/data_"):
        score_folders(made, true)
    # What a filter made of the image is a prediction.
    for path in true.glob("data_*.png"):
        write_map(folders[0] / path.name, gaussian_filter(image, (1, 3)))
    assert score_folders(folders[0], true, n_bootstrap=1)["ods"][0] > 0.5


def test_scores_below_those_of_a_constant_map_are_noted(tmp_path):
    between = edge_map(20)  # half-way to the next layer
    (ods, _), (note,) = of_files(tmp_path, between, MASK)
    share = MASK.mean()
    constant = 2 * share / (share + 1)
    assert ods < constant
    start = f"the best F of the set, {ods:.3g}, is below that of a map with all pixels on, "
    assert note.startswith(f"{start}{constant:.3g}")
    counts = match_counts(np.ones(MASK.shape), MASK, [0.5], thin=False)
    assert_allclose(score([counts])["ods"], constant, rtol=1e-12)


@pytest.mark.parametrize(("name", "value"), [("tolerance", "a"), ("processes", True)])
def test_what_is_no_number_is_refused_by_name_before_anything_is_read(name, value):
    with refusal(f"{name} must be .* at least [01], got"):
        score_folders("nowhere", "nowhere", **{name: value})


def test_a_map_that_is_only_like_its_image_is_scored(tmp_path, folders):
    _, true = folders
    rng = np.random.default_rng(2)
    image = rng.random(MASK.shape) + 3 * edge_map()
    made = tmp_path / "like"
    made.mkdir()
    for path in true.glob("data_*.png"):
        write_map(path, image / image.max())
        like = image + 0.2 * rng.standard_normal(MASK.shape)
        like = (like - like.min()) / np.ptp(like)
        np.save(made / f"{path.stem}.npy", like)
        assert 0.93 < np.corrcoef(like.ravel(), image.ravel())[0, 1] < 0.99
    assert score_folders(made, true, n_bootstrap=1)["ods"].iloc[0] > 0.5
