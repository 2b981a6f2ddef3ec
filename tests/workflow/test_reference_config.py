"""A reference flight that cannot be stops before any job starts, with the key's name."""

import re

import pytest
from runs import run_snakemake


@pytest.mark.parametrize(
    ("text", "expected"),
    [
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
def test_an_impossible_flight_is_refused_by_its_key(tmp_path, text, expected):
    override = tmp_path / "override.yaml"
    override.write_text(text + "\n")
    done = run_snakemake(tmp_path / "run", "--dry-run", configs=("config.yaml", override))
    assert done.returncode != 0
    lines = [line for line in (done.stdout + done.stderr).splitlines() if "config: " in line]
    assert len(lines) == 1
    assert re.search(expected, lines[0]), lines[0]
    assert not (tmp_path / "run/results").exists()
