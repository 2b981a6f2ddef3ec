"""A configuration that cannot be right stops before any job starts."""

import re

import pytest
from runs import lines_with, run_snakemake, settings, text_of


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("lables: {n_scenes: 3}", "lables"),
        ("labels: {n_scene: 3}", "labels: .*n_scene"),
        ("labels: {n_scenes: 0}", "labels.n_scenes: 0 "),
        ("labels: {n_scenes: many}", "labels.n_scenes: 'many' "),
        ("labels: {n_layers_min: 9, n_layers_max: 6}", "labels.n_layers_min: expected at most"),
        ("phy: {tolerance_db: -1}", "phy.tolerance_db: -1 "),
        ("phy: {width: widest}", "phy.width: 'widest' "),
        ("source: moon", "source: 'moon' "),
        ("seed: 1.5", "seed: 1.5 "),
        ("flight: {n_frames: 0}", r"flight\.n_frames: 0 "),
        ("flight: {n_frames: 9999}", r"flight\.n_frames: expected frames that fit on the line of 1\d\d\d km"),
        ("reference: {climate: {accumulation_factor: -1.0}}", r"climate\.accumulation_factor: -1\.0 "),
        ("reference: {firn: {surface_density_kg_m3: 950.0}}", r"firn\.surface_density_kg_m3: 950\.0 "),
        ("reference: {firn: {horizon_jump_kg_m3: 600.0}}", r"reference\.firn\.horizon_jump_kg_m3 must be at most 577"),
        ("reference: {firn: {fade_depth_m: 0.5}}", r"reference\.firn\.fade_depth_m must exceed fade_least_m 0\.9"),
        ("reference: {radar: {n_range_bins: 210}}", r"reference\.radar\.n_range_bins must be at least 2[23]\d"),
        ("reference: {radar: {n_sub_bins: 1}}", r"reference\.radar\.n_sub_bins must be at least 1\.73"),
    ],
)
def test_a_bad_key_is_named_in_one_line_and_nothing_is_written(tmp_path, text, expected):
    done = run_snakemake(tmp_path / "run", "--dry-run", configs=settings(tmp_path, text), fails=True)
    (line,) = [line for line in text_of(done).splitlines() if "config: " in line]
    assert re.search(expected, line), line
    assert not (tmp_path / "run/results").exists()


@pytest.mark.parametrize("configs", [("config.yaml",), ("config.yaml", "paper.yaml"), ("paper.yaml",)])
def test_the_dag_of_default_and_paper_scale_builds(tmp_path, configs):
    run_snakemake(tmp_path, "--dry-run", "--quiet", configs=configs)


@pytest.mark.parametrize("word", ["sead=7", "seed=seven"])
def test_a_slip_on_the_command_line_is_refused(tmp_path, word):
    done = run_snakemake(tmp_path / "run", "--dry-run", "--config", word, fails=True)
    (line,) = lines_with(done, "config: ")
    assert word.split("=")[0] in line
    assert not (tmp_path / "run/results").exists()
