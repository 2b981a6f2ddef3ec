"""Pictures of layers: what they leave blank, and names that stay apart."""

import numpy as np
import pytest
from made_up import made_up_frame
from matplotlib.figure import Figure
from PIL import Image
from refusals import refusal

import snowsim
from snowsim.io import write_picture

N_LINES = 40


def share_white(path):
    """Share of the picture that is white, as paper is."""
    return (np.asarray(Image.open(path).convert("L")) == 255).mean()


@pytest.fixture
def frame(rng):
    """Echogram and layers, the surface and one 69 bins below."""
    layer_bins = np.repeat([[30.0], [99.0]], N_LINES, axis=1)
    echogram, layers = made_up_frame(rng.gamma(4, 0.25, (120, N_LINES)), layer_bins)
    layers = layers.assign_coords(layer=["surface", "snow_1"])
    return echogram, layers.assign(echogram[["Latitude", "Longitude", "Elevation"]])


def test_lines_without_a_record_are_blank_in_a_picture(tmp_path, frame):
    echogram, layers = frame
    write_picture(tmp_path / "whole.png", layers, [echogram])
    half = slice(N_LINES // 2, None)
    echogram["Data"][:, half] = np.nan
    layers["twtt"][:, half] = np.nan
    write_picture(tmp_path / "gap.png", layers, [echogram])
    more_white = share_white(tmp_path / "gap.png") - share_white(tmp_path / "whole.png")
    # Half of the panel, which takes two thirds of a picture and more.
    assert 0.3 < more_white < 0.5


def test_lines_of_layers_are_those_of_the_echogram_to_a_millisecond(tmp_path, frame):
    echogram, layers = frame
    write_picture(tmp_path / "0.png", layers, [echogram])
    echogram["slow_time"] = echogram["slow_time"] + np.timedelta64(300, "us")
    write_picture(tmp_path / "300.png", layers, [echogram])
    assert (tmp_path / "0.png").read_bytes() == (tmp_path / "300.png").read_bytes()
    echogram["slow_time"] = echogram["slow_time"] + np.timedelta64(1, "h")
    with refusal("picture: expected an echogram of the layers' range lines"):
        write_picture(tmp_path / "none.png", layers, [echogram])


@pytest.mark.parametrize("rows", [[1], [0, 1]], ids=["a layer", "all"])
def test_layers_without_a_pick_are_no_obstacle(tmp_path, frame, rows):
    echogram, layers = frame
    layers["twtt"][rows] = np.nan
    write_picture(tmp_path / "picture.png", layers, [echogram])
    assert Image.open(tmp_path / "picture.png").size[0] > 0


def test_names_of_layers_that_end_together_do_not_overlap(tmp_path, frame, monkeypatch):
    drawn = []
    save = Figure.savefig
    monkeypatch.setattr(Figure, "savefig", lambda *a, **k: drawn.append(a[0]) or save(*a, **k))
    layers = frame[1].isel(layer=[0] + 11 * [1])
    layers["twtt"] = layers["twtt"] + 1e-10 * np.arange(12)[:, None]
    write_picture(tmp_path / "picture.png", layers)
    boxes = [text.get_window_extent() for text in drawn[0].axes[0].texts]
    assert len(boxes) == 12
    for below, box in enumerate(boxes, start=1):
        assert box.count_overlaps(boxes[below:]) == 0


def test_the_picture_of_accumulation_shows_the_error_of_every_date(tmp_path, monkeypatch):
    drawn = []
    save = Figure.savefig
    monkeypatch.setattr(Figure, "savefig", lambda *a, **k: drawn.append(a[0]) or save(*a, **k))
    climate = snowsim.Climate(accumulation_m=0.3, n_years=6)
    _, layers = snowsim.simulate(climate, "snow-2012", n_range_lines=64, rng=1)
    years = snowsim.accumulation(layers)
    write_picture(tmp_path / "picture.png", layers, accumulated=years)
    panel = next(ax for ax in drawn[0].axes if ax.get_xlabel() == "error of the year [years]")
    bars = [bar for bar in panel.patches if bar.get_height() == 0.5]
    assert len(bars) == years.sizes["year"]
    for bar, year in zip(bars, years["year"].values, strict=True):
        assert bar.get_y() + 0.25 == year
        ages = [years[name].sel(year=year).median() for name in ("age_low", "age_high")]
        assert bar.get_width() == ages[1] - ages[0]
    assert min(text.get_size() for text in [panel.xaxis.label, *panel.get_xticklabels()]) >= 8
