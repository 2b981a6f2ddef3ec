"""README's table of results is that of a run's tables, its pictures those of a run's files."""

import fill_tables
import numpy as np
import pandas as pd
import pytest
from matplotlib import pyplot as plt
from result_tables import SETS, table2, table3_intervals

from snowsim.echogram import Scene
from snowsim.io.files import write_dataset
from snowsim.io.scenes import write_scenes
from snowsim.reference import checked_settings, draw_climate, draw_frame


@pytest.fixture
def results(tmp_path):
    folder = tmp_path / "tables"
    folder.mkdir()
    table2([1, 2, 3], [2, 4, 6]).to_csv(folder / "table2.csv", index=False)
    planted = {("fuse", "rd_pd"): -0.25}
    table3_intervals(planted, 0.125).to_csv(folder / "table3_intervals.csv", index=False)
    scores = {f"{name}_{metric}": 0.75 for name in SETS for metric in ("ods", "ois", "ap")}
    table3 = pd.DataFrame([{"output": "side_1"} | scores, {"output": "fuse"} | scores])
    table3.assign(rd_pd_ods=[0.25, 0.5]).to_csv(folder / "table3.csv", index=False)
    return tmp_path


def test_means_and_differences_are_the_run_s_and_the_rest_of_the_page_is_kept(results):
    page = "before\n<!-- results -->\nold\n<!-- /results -->\nafter\n"
    filled = fill_tables.filled(page, results)
    assert filled.startswith("before\n<!-- results -->\n|  | RD |")
    assert filled.endswith("|\n<!-- /results -->\nafter\n")
    assert "| renders: SSIM |  | 2.00 | 4.00 |  |" in filled
    assert "| ODS | .750 | .750 [-0.125, +0.125] | .500 [-0.375, -0.125] |" in filled
    assert fill_tables.filled(filled, results) == filled


def test_readme_has_the_place_and_a_page_without_it_is_refused(results):
    filled = fill_tables.filled(fill_tables.README.read_text(), results)
    assert "| renders: SSIM |  | 2.00 | 4.00 |  |" in filled
    with pytest.raises(ValueError, match="expected <!-- results -->"):
        fill_tables.filled("<!-- results -->\nnever closed\n", results)


def test_the_picture_is_an_echogram_with_its_tracked_layers_beside_both_renders(tmp_path, rng):
    settings = checked_settings({"radar": {"n_range_bins": 600}})
    climate = draw_climate(settings, rng=rng)
    echogram, _ = draw_frame(0, 1, 600, climate=climate, settings=settings, rng=rng)
    write_dataset(tmp_path / f"flight/{fill_tables.FRAME}.nc", echogram)
    layer_bins = 50 + 10.0 * np.arange(fill_tables.LEAST_LAYERS + 1)[:, None] * np.ones(64)
    for method in ("phy", "cgan"):
        image = rng.integers(0, 256, (320, 64), dtype=np.uint8)
        scene = Scene("0", 320, layer_bins, image=image)
        write_scenes(tmp_path / f"{method}/labels/0000.nc", [scene], {"method": method})
    figure = fill_tables.sample(tmp_path)
    shown = [ax.images[0].get_array() for ax in figure.axes]
    plt.close(figure)
    assert shown[0].shape == (fill_tables.N_ROWS, fill_tables.N_LINES)
    assert [image.shape for image in shown[1:]] == [(fill_tables.N_ROWS, 64)] * 2
    assert len(figure.axes[0].lines) > 1
