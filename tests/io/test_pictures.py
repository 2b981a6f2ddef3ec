"""Pictures of layers: what they leave blank, and names that stay apart."""

import formats
import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from PIL import Image

from snowsim.io import read_echogram, write_picture


def share_white(path):
    """Share of the picture that is white, as paper is."""
    return (np.asarray(Image.open(path).convert("L")) == 255).mean()


@pytest.fixture
def frame(tmp_path, content):
    """Echogram and layers as other tools write them, surface and one below."""
    formats.opr_dataset(content).to_netcdf(tmp_path / "frame.nc")
    echogram = read_echogram(tmp_path / "frame.nc")
    surface = content["Surface"]
    names = ["surface", "snow_1"]
    layers = formats.opr_layers([surface, surface + 2e-8], content["GPS_time"], names)
    positions = echogram[["Latitude", "Longitude", "Elevation"]]
    return echogram, xr.merge([layers, positions])


def test_lines_without_a_record_are_blank_in_a_picture(tmp_path, frame):
    echogram, layers = frame
    write_picture(tmp_path / "whole.png", layers, [echogram])
    half = np.arange(formats.N_LINES) < formats.N_LINES // 2
    kept = xr.DataArray(half, dims="slow_time")
    layers = layers.assign(twtt=layers["twtt"].where(kept))
    echogram = echogram.assign(Data=echogram["Data"].where(kept))
    write_picture(tmp_path / "gap.png", layers, [echogram])
    more_white = share_white(tmp_path / "gap.png") - share_white(tmp_path / "whole.png")
    # Half of the panel, which takes two thirds of a picture and more.
    assert 0.3 < more_white < 0.5


@pytest.mark.parametrize("rows", [[1], [0, 1]], ids=["a layer", "all"])
def test_layers_without_a_pick_are_no_obstacle(tmp_path, frame, rows):
    echogram, layers = frame
    layers["twtt"][rows] = np.nan
    write_picture(tmp_path / "picture.png", layers, [echogram])
    assert Image.open(tmp_path / "picture.png").size[0] > 0


def test_names_of_layers_that_end_together_do_not_overlap(tmp_path, content, frame, monkeypatch):
    drawn = []
    save = Figure.savefig
    monkeypatch.setattr(Figure, "savefig", lambda *a, **k: drawn.append(a[0]) or save(*a, **k))
    surface = content["Surface"]
    twtt = [surface, *(surface + 2e-8 + 1e-10 * n for n in range(11))]
    names = ["surface", *(f"snow_{n}" for n in range(1, 12))]
    layers = formats.opr_layers(twtt, content["GPS_time"], names)
    positions = frame[0][["Latitude", "Longitude", "Elevation"]]
    write_picture(tmp_path / "picture.png", layers.assign(positions))
    boxes = [text.get_window_extent() for text in drawn[0].axes[0].texts]
    assert len(boxes) == 12
    for below, box in enumerate(boxes, start=1):
        assert box.count_overlaps(boxes[below:]) == 0
