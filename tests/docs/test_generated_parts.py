"""Parts of pages that are made: the configuration reference, and README's tables."""

import os
import re

import configuration
import fill_tables
import numpy as np
import pandas as pd
import pytest
import stamps
import xarray as xr
import yaml
from click.testing import CliRunner
from result_tables import SETS, picks, table2, table3_intervals, worth
from runs import SCHEMA
from transfer_tables import TRACKERS

from lib.configuration import stages
from snowsim.echogram import Scene
from snowsim.io.scenes import write_scenes

STAMP = "flight 00000000, scenes 00000000, labels 00000000"


def test_every_setting_is_listed_once_with_its_default_and_a_comment():
    settings = configuration.read_settings(configuration.CONFIG.read_text(), SCHEMA)
    assert [setting.path for setting in settings if not setting.comment] == []
    written = yaml.safe_load(configuration.CONFIG.read_text())
    for setting in settings:
        if setting.default:
            value = written
            for key in setting.path:
                value = value[key]
            assert yaml.safe_load(setting.default) == value, setting.path
    for stage, told in stages().items():
        settings += configuration.recipe_settings(stage, told)
    shown = [line for line in configuration.reference().splitlines() if line.startswith("| `")]
    listed = {setting.path for setting in settings if setting.default is not None}
    assert len(shown) == len(listed) > 190


def test_comments_go_on_in_their_column_and_limits_are_said():
    number = {"type": ["number", "null"], "exclusiveMinimum": 0}
    schema = {
        "properties": {"s": {"properties": {"a": {"$ref": "#/$defs/n"}}}},
        "$defs": {"n": number},
    }
    text = "s:        # a_* section, `b_*`\n  a: null # [m] length,\n          # measured\n"
    section, setting = configuration.read_settings(text, schema)
    assert (section.comment, section.default) == ("a_* section, `b_*`", None)
    assert r"a\_\* section, `b_*`" in configuration.markdown([section, setting])
    assert (setting.comment, setting.default) == ("[m] length, measured", "null")
    assert setting.accepted == "number above 0 or `null`"


@pytest.fixture
def results(tmp_path):
    folder = tmp_path / "results"
    (folder / "tables").mkdir(parents=True)
    (folder / "benchmarks/train/a").mkdir(parents=True)
    table2([1, 2, 3], [2, 4, 6]).to_csv(folder / "tables/table2.csv", index=False)
    intervals = table3_intervals({("fuse", name): -0.25 for name in SETS}, 0.25, outputs=["fuse"])
    intervals.to_csv(folder / "tables/table3_intervals.csv", index=False)
    picks().to_csv(folder / "tables/picks.csv", index=False)
    for name, seconds in (("a/0", 30.0), ("a/1", 60.0)):
        run = pd.DataFrame({"s": [seconds], "max_rss": [seconds]})
        run.to_csv(folder / f"benchmarks/train/{name}.tsv", sep="\t", index=False)
    return folder


def test_a_block_is_replaced_by_its_table_and_the_rest_is_kept(results):
    text = "before\n<!-- similarity -->\nold\n<!-- /similarity -->\nafter\n"
    filled, left = fill_tables.fill(text, results, STAMP)
    assert left == []
    assert filled.startswith("before\n")
    assert filled.endswith("after\n")
    assert "old" not in filled
    assert "of the 60 test masks" in filled
    assert "| SSIM | 1.00 / 2.00 / 3.00 | 2.00 / 4.00 / 6.00 |" in filled


def test_filling_twice_changes_nothing_more(results):
    text = "".join(
        f"<!-- {name} -->\n<!-- /{name} -->\n" for name in ("intervals", "picks", "cost")
    )
    once, _ = fill_tables.fill(text, results, STAMP)
    assert fill_tables.fill(once, results, STAMP)[0] == once
    assert "| ODS | -0.2500 [-0.5000, +0.0000] |" in once
    assert "2 trainings a set are too few" in once
    assert "| mean absolute error [bins] | 1.00 | 1.00 | 1.00 | 1.00 |" in once
    assert "| layers missed, of 40 | 5 | 5 | 5 | 5 |" in once
    assert "| `train` | 2 | 90 | 100 % | 60 |" in once


def test_intervals_are_those_of_the_study_where_it_has_more_trainings(results):
    (results / "studies/tracker").mkdir(parents=True)
    for n_replicas, shown in ((5, True), (2, False)):
        of_study = worth(n_replicas, difference=0.125, low=0.0625, high=0.1875)
        of_study.to_csv(results / "studies/tracker/worth.csv", index=False)
        filled, _ = fill_tables.fill("<!-- intervals -->\n<!-- /intervals -->\n", results, STAMP)
        assert ("| ODS | +0.1250 [+0.0625, +0.1875] |" in filled) == shown
        assert ("5 trainings a set" in filled) == shown


def test_tables_of_flights_never_seen_hold_every_tracker_and_what_its_confidence_is_worth(results):
    scores = dict.fromkeys(("ods", "ois", "ap", "f", "recall", "precision"), 0.5)
    scores |= {"mean_error_bins": 0.75, "missed_share": 0.125, "false_share": 0.25}
    rows = [
        {"flight": flight, "tracker": tracker, **scores}
        for flight in ("a_flight", "mean")
        for tracker in TRACKERS
    ]
    pd.DataFrame(rows).to_csv(results / "tables/transfer.csv", index=False)
    curve = {"tracker": "universal", "said": [0.1, 0.5, 0.9], "seen": [0.9, 0.4, 0.85]}
    curves = [pd.DataFrame(curve).assign(flight=name) for name in "ab"]
    # Of the first class, one pick in a thousand: too few to be shown.
    pd.concat(curve.assign(n_pixels=[1, 499, 500]) for curve in curves).to_csv(
        results / "tables/transfer_reliability.csv", index=False
    )
    names = ("transfer", "transfer_picks", "transfer_confidence")
    text = "".join(f"<!-- {name} -->\n<!-- /{name} -->\n" for name in names)
    filled, left = fill_tables.fill(text, results, STAMP)
    assert left == []
    assert "| a flight |" + " .500/.500/.500 |" * len(TRACKERS) in filled
    assert "| mean | universal | .500 | .500 | .500 | 0.75 | 12 % | 25 % |" in filled
    assert "Largest difference 0.100" in filled
    assert "| .500 | .400 | 50 % |" in filled
    assert ".100 | .900" not in filled


def test_a_block_without_its_table_is_left_and_named_and_one_not_closed_is_refused(results):
    text = "<!-- realism -->\nold\n<!-- /realism -->\n"
    filled, (left,) = fill_tables.fill(text, results, STAMP)
    assert filled == text
    assert "realism.csv" in left
    with pytest.raises(ValueError, match=r"expected <!-- /similarity -->"):
        fill_tables.fill("<!-- similarity -->\nold\n", results, STAMP)


@pytest.mark.parametrize("page", fill_tables.PAGES, ids=lambda page: page.name)
def test_pages_hold_blocks_that_are_known_and_closed(page):
    text = page.read_text()
    opened = [block.name for block in stamps.blocks_of(text)]
    assert opened
    assert set(opened) <= {block.__name__ for block in fill_tables.BLOCKS}
    assert re.findall(r"<!-- /(\w+) -->", text) == opened


def test_every_table_on_a_page_is_of_the_flight_in_use_or_says_in_its_first_line_that_it_is_not():
    blocks = [block for page in fill_tables.PAGES for block in stamps.blocks_of(page.read_text())]
    current = next(block.stamp for block in blocks if block.name == "tables")
    assert current.startswith(f"flight {stamps.of_statistics(fill_tables.PACKAGED)}, ")
    unmarked = [block for block in blocks if block.has_table and not block.is_marked]
    assert [block.name for block in unmarked if block.stamp != current] == []
    marked = [block for block in blocks if block.is_marked]
    assert [block.name for block in marked if block.stamp in ("", current)] == []


@pytest.fixture
def finished(results):
    """A run with statistics, label sets and tables of a study that are newer."""
    (results / "labels").mkdir()
    values = {"power": ("layer", np.array([1.0, 0.1])), "n": ("layer", np.array([3, 4]))}
    xr.Dataset(values).to_netcdf(results / "statistics.nc")
    (results / "labels/0000.nc").write_bytes(b"drawn")
    (results / "studies/tracker").mkdir(parents=True)
    table = worth(5, difference=0.125, low=0.0625, high=0.1875)
    table = table.assign(mean=0.75, n_images=20, outcome="higher")
    for name in ("worth", "ablation"):
        table.to_csv(results / f"studies/tracker/{name}.csv", index=False)
    return results


def test_statistics_have_the_same_stamp_in_the_package_s_precision_and_another_if_they_differ(
    finished,
):
    ours = stamps.of_statistics(finished / "statistics.nc")
    with xr.open_dataset(finished / "statistics.nc") as statistics:
        statistics.assign(power=statistics["power"].astype(np.float32)).to_netcdf(
            finished / "packaged.nc"
        )
        statistics.assign(power=1.001 * statistics["power"]).to_netcdf(finished / "other.nc")
    assert stamps.of_statistics(finished / "packaged.nc") == ours
    assert stamps.of_statistics(finished / "other.nc") != ours


def test_the_stamp_of_a_run_tells_flight_and_label_sets_apart(finished):
    before = stamps.of_run(finished)
    (finished / "labels/0000.nc").write_bytes(b"drawn again")
    after = stamps.of_run(finished)
    assert before.split(", ")[:2] == after.split(", ")[:2]
    assert before.split(", ")[2] != after.split(", ")[2]


def test_the_stamp_of_scenes_is_that_of_another_processor_s_and_not_that_of_other_scenes(tmp_path):
    image = np.full((80, 32), 100, np.uint8)
    pixel, level = image.copy(), image + 1
    pixel[3, 4] += 1
    layers = np.full((1, 32), 50.0)
    found = []
    for name, made, at in (
        ("ours", image, layers),
        ("of another processor", pixel, layers),
        ("brighter", level, layers),
        ("deeper", image, layers + 1),
    ):
        write_scenes(tmp_path / f"{name}.nc", [Scene("a", 80, at, made)], {})
        found.append(stamps.of_scenes([tmp_path / f"{name}.nc"]))
    assert found[0] == found[1]
    assert len(set(found)) == 3


def test_a_study_older_than_the_label_sets_is_refused_and_what_the_page_holds_is_marked(finished):
    text = "<!-- ablation: flight 1 -->\n| a |\n|---|\n<!-- /ablation -->\n"
    renewed, left = fill_tables.fill(text, finished, STAMP)
    assert left == []
    assert f"<!-- ablation: {STAMP} -->" in renewed
    assert "5 trainings a set" in fill_tables.intervals(finished)
    for name in ("worth", "ablation"):
        os.utime(finished / f"studies/tracker/{name}.csv", (0, 0))
    filled, (reason,) = fill_tables.fill(text, finished, STAMP)
    assert filled == text
    assert "studies/tracker/ablation.csv is older than" in reason
    for page in (text, text.replace("ablation: flight 1", "ablation")):
        marked, _ = fill_tables.fill(page, finished, STAMP, "flight: the last")
        (block,) = stamps.blocks_of(marked)
        assert block.is_marked
        assert block.text.startswith("*Of an earlier flight: the last.*\n\n| a |")
        assert fill_tables.fill(marked, finished, STAMP, "flight: another")[0] == marked
    assert "5 trainings a set" not in fill_tables.intervals(finished)


def test_a_run_of_another_flight_than_the_package_s_is_refused_in_one_line(finished):
    before = [page.read_bytes() for page in fill_tables.PAGES]
    told = CliRunner().invoke(fill_tables.main, [str(finished)])
    assert told.exit_code == 1
    assert re.fullmatch(
        r"Error: .*: expected a run of flight \w{8}, the package's, found flight \w{8}\n",
        told.output,
    )
    assert [page.read_bytes() for page in fill_tables.PAGES] == before


def test_scores_of_conventions_on_the_page_of_choices_are_those_of_the_table():
    accuracy, choices = (
        (fill_tables.ROOT / page).read_text()
        for page in ("docs/accuracy.md", "docs/stages/choices.md")
    )
    table = next(block for block in stamps.blocks_of(accuracy) if block.name == "conventions")
    rows = [line.strip("| ").split(" | ") for line in table.text.splitlines()[2:] if line]
    scores = {tuple(name.strip("`") for name in row[:4]): row[-1] for row in rows}
    assert f"default's is {scores['deblended', 'peak', 'peak', 'fitted']}," in choices
    departures = {
        "estimator, scale and place": ("paper", "none", "gaussian", "paper"),
        "scale of the waveform alone": ("deblended", "none", "peak", "fitted"),
        "place of the waveform alone": ("deblended", "peak", "gaussian", "fitted"),
        "width alone": ("deblended", "peak", "peak", "paper"),
    }
    for departure, convention in departures.items():
        (row,) = re.findall(rf"\| {departure}.*", choices)
        assert re.search(r"closed loop ([\d.]+)", row)[1] == scores[convention], departure
