"""README's table of results is that of a run's tables, its pictures those of a run's files."""

import fill_tables
import pandas as pd
import pytest
from refusals import refusal
from result_tables import SETS, table2, table3_intervals


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
    with refusal("expected <!-- results -->"):
        fill_tables.filled("<!-- results -->\nnever closed\n", results)
