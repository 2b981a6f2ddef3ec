"""Tables of README and pages are those of a run's files."""

import re
import subprocess

import fill_tables
import numpy as np
import pandas as pd
import pytest
import table_commits
from claims import (
    claims_of_flights,
    claims_of_trackers,
    off_where_bent,
    radial_spectrum_db,
    verdict,
)
from numpy.testing import assert_allclose
from refusals import refusal
from result_tables import SETS, table2, table3_intervals

from snowsim.echogram import Scene


@pytest.fixture
def results(tmp_path):
    folder = tmp_path / "tables"
    folder.mkdir()
    table2([1, 2, 3], [2, 4, 6]).to_csv(folder / "table2.csv", index=False)
    planted = {("fuse", "rd_pd"): -0.25}
    table3_intervals(planted, 0.125).to_csv(folder / "table3_intervals.csv", index=False)
    scores = {f"{name}_{metric}": 0.75 for name in SETS for metric in ("ods", "ois", "ap", "f")}
    table3 = pd.DataFrame([{"output": "side_1"} | scores, {"output": "fuse"} | scores])
    table3.assign(rd_pd_ods=[0.25, 0.5]).to_csv(folder / "table3.csv", index=False)
    return tmp_path


def test_means_and_differences_are_the_run_s_and_the_rest_of_the_page_is_kept(results):
    page = "before\n<!-- results -->\nold\n<!-- /results -->\nafter\n"
    filled, missing = fill_tables.filled(page, results)
    assert missing == []
    assert filled.startswith("before\n<!-- results -->\n|  | RD |")
    assert re.search(r"\|\n\nCommit [0-9a-f]{8}\.\n<!-- /results -->\nafter\n$", filled)
    assert "| renders: SSIM |  | 2.00 | 4.00 |  |" in filled
    assert "| ODS | .750 | .750 [-0.125, +0.125] | .500 [-0.375, -0.125] |" in filled
    assert fill_tables.filled(filled, results) == (filled, [])


def test_a_table_without_its_files_stays_and_is_named(results):
    page = "<!-- picks -->\nold\n<!-- /picks -->\n<!-- table2 -->\n<!-- /table2 -->\n"
    filled, (missing,) = fill_tables.filled(page, results)
    assert filled.startswith("<!-- picks -->\nold\n")
    assert "| SSIM | 1.00 / 2.00 / 3.00 | 2.00 / 4.00 / 6.00 |" in filled
    assert missing.startswith("picks: ")
    assert missing.endswith("picks.csv")


def test_the_study_of_flights_shows_its_pairs_and_p_values_of_tests_alone(tmp_path, monkeypatch):
    ods = {"rd": 0.50, "rd_sample": 0.51, "rd_pd": 0.75, "rd_sample_pd": 0.52}
    rows = [
        {"training_set": name, "flight": flight, "ods": value**flight, "ois": 1.0, "ap": 0.8}
        for name, value in ods.items()
        for flight in (1, 2)
    ]
    folder = tmp_path / "workflow/evaluation"
    folder.mkdir(parents=True)
    pd.DataFrame(rows).to_csv(folder / "measured_flights.csv", index=False)
    monkeypatch.setattr(fill_tables, "ROOT", tmp_path)
    table = fill_tables.flights(tmp_path).splitlines()[2:]
    # Means of .75 and .5625, of .51 and .2601; differences of .2400 and .3024.
    assert table[0].startswith("| RD+PD less RD + sample flight | 0.656, 0.385 | +0.271 [-0.125, ")
    assert table[0].endswith("| 0.073 | +0.000 [+0.000, +0.000] | 2 of 2 |")
    # Two of four secondary pairs, so that their level is not known yet, and one that is explored.
    p_values = [row.split(" | ")[3] for row in table[1:]]
    assert p_values == ["", "", ""]


def test_costs_of_a_run_that_left_no_benchmarks_stay(results):
    page = "<!-- costs -->\nold\n<!-- /costs -->\n"
    filled, (missing,) = fill_tables.filled(page, results)
    assert filled == page
    assert missing.endswith("benchmarks")


def test_agreement_of_flights_stands_beside_f(tmp_path, monkeypatch):
    flights = {"flight": ["noisy_one", "rank correlation with f"], "f": [0.5, np.nan]}
    figures = ("share_matched", "depth_rms_m", "accumulation_rms_m_we", "share_same_year", "offset")
    table = pd.DataFrame(flights | {name: [0.25, -0.5] for name in figures})
    (tmp_path / "benchmarks").mkdir()
    table.to_csv(tmp_path / "benchmarks/agreement_by_flight.csv", index=False)
    monkeypatch.setattr(fill_tables, "ROOT", tmp_path)
    filled, _ = fill_tables.filled("<!-- agreement -->\n<!-- /agreement -->\n", tmp_path)
    assert "| noisy one | 0.500 | 0.250 | 0.250 | 0.250 | 0.250 | 0.25 |\n" in filled
    assert "| rank correlation with f |  | -0.500 | -0.500 | -0.500 | -0.500 | -0.50 |\n" in filled


def test_a_place_that_is_not_closed_or_of_no_table_is_refused(results):
    for page in ("<!-- results -->\nnever closed\n", "<!-- other -->\n<!-- /other -->\n"):
        with refusal("expected the name of a table"):
            fill_tables.filled(page, results)


def test_every_table_has_its_place_on_a_page():
    pages = [fill_tables.README, *(fill_tables.ROOT / "docs").rglob("*.md")]
    text = "".join(page.read_text() for page in pages)
    for name in fill_tables.TABLES:
        assert text.count(f"<!-- {name} -->\n") == text.count(f"<!-- /{name} -->\n") == 1, name


def committed_tables():
    """Name and commit of every table on the pages, and what is said of changes since."""
    for page in (fill_tables.README, *sorted((fill_tables.ROOT / "docs").rglob("*.md"))):
        text = page.read_text()
        for name in re.findall(r"^<!-- (\w+) -->$", text, flags=re.MULTILINE):
            table = text.partition(f"<!-- {name} -->")[2].partition(f"<!-- /{name} -->")[0]
            if "|---" not in table:  # a study that was not run yet
                continue
            line = table.rpartition("\n\n")[2].replace("\n", " ").strip()
            told = re.fullmatch(r"Commit ([0-9a-f]{8})(; .+)?\.", line)
            assert told, f"{page.name}: table {name}: expected its commit below it, got {line!r}"
            yield pytest.param(name, *told.groups(""), id=name)


@pytest.mark.parametrize(("name", "commit", "since"), list(committed_tables()))
def test_a_page_says_so_if_the_code_of_a_table_has_changed(name, commit, since):
    """Of studies that are scored once; other tables are made anew when their code changes."""
    try:
        is_shallow = table_commits.git("rev-parse", "--is-shallow-repository").strip()
    except (subprocess.CalledProcessError, FileNotFoundError):
        is_shallow = None
    if is_shallow != "false":
        pytest.skip("no git history to look up the commit in")
    table_commits.git("merge-base", "--is-ancestor", commit, "HEAD")
    paths = table_commits.SCORED_ONCE.get(name, ())
    changed = table_commits.changed_since(commit, paths) if paths else []
    assert bool(since) == bool(changed), f"changed since {commit}: {changed}"


def test_words_alone_are_no_change_of_code(tmp_path, monkeypatch):
    monkeypatch.setattr(table_commits, "ROOT", tmp_path)
    author = ["-c", "user.name=a", "-c", "user.email=a@b", "commit", "-qm"]
    table_commits.git("init", "-q")
    for name in ("words.py", "code.py", "gone.py"):
        (tmp_path / name).write_text('"""Room."""\n\n\ndef f():\n    """First."""\n    return 1\n')
    table_commits.git("add", ".")
    table_commits.git(*author, "first")
    (tmp_path / "words.py").write_text('def f():\n    """Other."""\n    return 1  # one\n')
    (tmp_path / "code.py").write_text('def f():\n    """First."""\n    return 2\n')
    (tmp_path / "gone.py").unlink()
    assert table_commits.changed_since("HEAD", ["."]) == ["code.py", "gone.py"]
    assert table_commits.changed_since("HEAD", ["words.py"]) == []


def test_verdicts_follow_from_the_side_of_zero():
    assert [verdict(*interval) for interval in ((0.1, 0.2), (-0.1, 0.2), (-0.2, -0.1))] == [
        "indicated",
        "open",
        "the opposite is indicated",
    ]
    rows = claims_of_trackers(table3_intervals({("fuse", "rd_pd"): -0.25}, 0.125))
    outcomes = {claim: outcome for claim, outcome, _ in rows}
    assert outcomes["RD+PD raises the fused ODS"] == "the opposite is indicated"
    assert outcomes["RD+GD raises the fused ODS"] == "open"


def test_only_tests_over_flights_that_were_named_before_confirm_a_claim():
    rows = [
        ("rd_pd", "rd_sample", "endpoint", 0.02, 0.01, np.nan),
        ("rd_pd", "rd", "secondary", 0.03, 0.01, 0.04),
        ("rd_pd", "rd_completed", "secondary", -0.02, 0.02, 0.04),
        ("rd_gd_picked", "rd", "secondary", 0.01, 0.03, 0.12),
        ("pd", "rd", "exploratory", 0.04, np.nan, np.nan),
    ]
    columns = ["training_set", "base", "role", "mean", "p", "p_holm"]
    worth = pd.DataFrame(rows, columns=columns).assign(metric="ods", low=-1.0, high=1.0)
    found = claims_of_flights(pd.concat([worth, worth.assign(metric="ap")]))
    outcomes = [outcome for _, outcome, _ in found]
    assert outcomes == ["confirmed", "confirmed", "contradicted", "open"]
    assert found[0][0] == "RD+PD has a higher fused ODS than RD + sample flight, over flights"


@pytest.mark.parametrize("off_bins", [0, 3])
def test_the_brightest_pixel_is_as_far_off_a_bent_layer_as_it_is_drawn(off_bins):
    line = np.arange(256)
    layer_bins = np.rint([np.full(256, 50.0), 80 + 10 * np.sin(line / 20)])
    scene = Scene("bent", 300, layer_bins, complete_layer_bins=layer_bins)
    image = np.zeros((300, 256), dtype=np.uint8)
    image[layer_bins[1].astype(int) + off_bins, line] = 255
    assert off_where_bent(scene, image) == off_bins


def test_a_spectrum_s_level_is_that_of_the_image_s_power(rng):
    image = rng.standard_normal((300, 256))
    raised_db = radial_spectrum_db(2 * image) - radial_spectrum_db(image)
    assert_allclose(raised_db, 20 * np.log10(2), rtol=1e-9)
    # White noise: as many bands, one level; some 1e2 wavenumbers a band scatter by .4 dB.
    assert np.ptp(radial_spectrum_db(image)) < 3


def test_the_page_of_accumulation_has_the_dates_of_the_benchmark():
    page = (fill_tables.ROOT / "docs/stages/accumulation.md").read_text()
    for table in (fill_tables.dates(None), fill_tables.dated_cases(None)):
        assert table in page
    score = pd.read_csv(fill_tables.ROOT / "benchmarks/years_by_class.csv")
    brier, constant = (
        f"{score[name][0]:.3f}".removeprefix("0") for name in ("brier", "brier_of_a_constant")
    )
    assert f"The Brier score is {brier}, that of a constant {constant}." in page
