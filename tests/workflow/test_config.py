"""A wrong configuration stops before any job, in one line that names key, expected and got."""

import re
from copy import deepcopy
from dataclasses import fields, is_dataclass, replace

import pytest
import yaml
from jsonschema import Draft202012Validator
from refusals import refusal
from runs import (
    CONFIG,
    ROOT,
    SCHEMA,
    WRITTEN,
    parsed,
    refused,
)
from snakemake.cli import parse_config
from snakemake.utils import update_config

from lib.configuration import RECIPES, filled


def at_the_limits(limits, is_whole):
    """Values that limits of a number just accept, and ones that they just refuse."""
    inside = []
    outside = []
    for key, sign in (("low", -1), ("high", 1)):
        if key in limits:
            outwards = sign * (1 if is_whole else 1e-9 * max(1, abs(limits[key])))
            is_excluded = key == "low" and limits.get("above", False)
            inside.append(limits[key] - outwards * is_excluded)
            outside.append(limits[key] + outwards * (not is_excluded))
    return inside, outside


def test_the_schema_accepts_the_default_and_refuses_keys_that_it_does_not_know():
    Draft202012Validator.check_schema(SCHEMA)
    assert Draft202012Validator(SCHEMA).is_valid(WRITTEN)
    parts = [SCHEMA, *SCHEMA["$defs"].values()]
    for part in parts:
        if "items" in part:
            parts.append(part["items"])
        parts += part.get("properties", {}).values()
        if "properties" in part:
            assert part["additionalProperties"] is False, part


def groups_of(recipe):
    """The dataclasses of a recipe whose fields are settings."""
    groups = [getattr(recipe, each.name) for each in fields(recipe)]
    return list(filter(is_dataclass, groups)) or [recipe]


@pytest.mark.parametrize("stage", RECIPES)
def test_the_package_refuses_what_the_limits_of_its_settings_exclude(stage):
    for group in groups_of(next(iter(RECIPES[stage].values()))):
        for each in fields(group):
            limits = each.metadata["limits"]
            is_list = each.type is tuple
            inside, outside = at_the_limits(limits, is_whole="int" in str(each.type))
            # Settings of the flight also limit each other.
            for value in inside if stage != "reference" else []:
                replace(group, **{each.name: [value] if is_list else value})
            for value in [*outside, "none of these", {}, *([None] if inside else [])]:
                if value is None and "None" in str(each.type):
                    continue
                with refusal(each.name):
                    replace(group, **{each.name: [value] if is_list else value})


def test_the_default_names_what_a_user_turns_and_no_setting_of_a_recipe():
    for stage, recipes in RECIPES.items():
        if stage == "reference":
            assert WRITTEN[stage] in recipes
        else:
            names = {each.name for each in fields(next(iter(recipes.values())))}
            assert not names & set(WRITTEN[stage]), stage
            assert WRITTEN[stage]["recipe"] == next(iter(recipes))


def test_a_setting_named_beside_a_recipe_wins_and_the_rest_is_the_recipe_s():
    written = deepcopy(WRITTEN)
    written["cgan"] |= {"recipe": "paper", "training": {"width": 3}}
    written["reference"] = {"climate": {"accumulation_factor": 0.5}}
    made = filled(written)
    training = made["cgan"]["training"]
    assert (training["width"], training["method"]) == (3, "pix2pix")
    climate = CONFIG["reference"]["climate"] | {"accumulation_factor": 0.5}
    assert made["reference"] == CONFIG["reference"] | {"climate": climate}


def test_a_configuration_that_names_every_setting_means_what_it_says():
    changed = deepcopy(CONFIG)
    changed["phy"]["n_looks"] = 5
    assert filled(changed) == changed
    # As a run in a folder of its own reads it.
    assert filled(yaml.safe_load(yaml.safe_dump(changed))) == changed


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("sead: 7", "sead"),
        ("flight: {n_frames: 4.0}", "4.0 is not of type 'integer'"),
        ("phy: {recipe: papers}", "phy.recipe: expected measured or paper, got papers"),
        (
            "tracker: {training: {optimiser: sgd}}",
            "tracker.training: optimiser: unknown key, expected some of network, width",
        ),
        ("reference: {climate: 3}", "reference: climate: expected names with values, got 3"),
        ('import: {description: "a\\nb"}', "import.description: .*expected: one line"),
        (
            "flight: {n_frames: 9999}",
            r"flight\.n_frames: expected frames that fit on the line of 1\d\d\d km",
        ),
        (
            "reference: {radar: {n_range_bins: 210}}",
            r"reference: radar\.n_range_bins .* at least 2[23]\d",
        ),
    ],
)
def test_a_bad_key_is_named_in_one_line(tmp_path, text, expected):
    assert re.search(f"^config: .*{expected}", refused(tmp_path, **yaml.safe_load(text)))


def test_the_dag_of_the_paper_s_scale_builds_and_needs_no_default_beside_it(tmp_path):
    alone = parsed(tmp_path, ("paper.yaml",), targets=["all"])
    beside = parsed(tmp_path, ("config.yaml", "paper.yaml"))
    assert alone.globals["config"] == beside.globals["config"]
    parsed(tmp_path, ("config.yaml", "as_printed.yaml", "paper.yaml"), targets=["all"])


def test_the_test_seed_draws_the_test_scenes_alone(tmp_path):
    plan = parsed(tmp_path, targets=["flight"], benchmark={"test_seed": 5})
    drawn = [job for job in plan.dag.jobs if job.rule.name == "reference_scenes"]
    seeds = {job.wildcards.split: job.params.scene_seed for job in drawn}
    seed = CONFIG["seed"]
    assert seeds == {"train": seed, "validation": seed, "test": 5}
    # The years of snow are the flight's.
    assert {job.params.seed for job in drawn} == {seed}


def test_the_run_as_printed_shares_flight_and_benchmark_alone(tmp_path):
    # A size that its own recipe of the cGAN would refuse is the measured one's.
    plan = parsed(tmp_path, targets=["as_printed"], cgan={"training": {"n_range_bins": 192}})
    files = {file for job in plan.dag.jobs for file in job.output}
    shared = {file.split("/")[1] for file in files if not file.startswith("results/as_printed/")}
    assert shared == {"flight", "benchmark", "statistics"}  # of the last the sums over frames
    assert "results/as_printed/tables/table3.csv" in files


def test_what_is_printed_otherwise_stands_among_the_departures():
    written = deepcopy(WRITTEN)
    update_config(written, yaml.safe_load((ROOT / "config/as_printed.yaml").read_text()))
    text = (ROOT / "docs/stages/choices.md").read_text()
    after = text.split("## Where the default departs from the paper")[1]
    departures = after.split("\n## ")[0]
    for section, settings_of_section in filled(written).items():
        if isinstance(settings_of_section, dict):
            for key, value in settings_of_section.items():
                if value != CONFIG[section][key]:
                    assert re.search(rf"\b{key}\b", departures), f"{section}.{key}"


@pytest.mark.parametrize(
    ("said", "job", "value"),
    [
        ("labels={n_scenes: 1400, nonstationary: {zones: [0, 2]}}", "draw_labels", "[0, 2]"),
        ("cgan={training: {n_steps: 7}, picks: as_picked}", "train_cgan", "'n_steps': 7,"),
        ("reference={radar: {bandwidth_hz: 3.5e+9}}", "reference_scenes", "3500000000.0"),
    ],
)
def test_nested_values_of_the_command_line_have_the_types_of_a_file(tmp_path, said, job, value):
    flow = parsed(tmp_path, targets=["all"], **parse_config([said]))
    params = [dict(each.params.items()) for each in flow.dag.jobs if each.rule.name == job]
    assert params
    assert all(value in str(found) for found in params)


def test_text_of_the_command_line_that_is_wrong_is_refused_by_its_key(tmp_path):
    for said, line in (
        ("phy={n_looks: many}", "config: phy: n_looks must be finite"),
        ("labels={n_scenes: 12.0}", "config: labels.n_scenes: 12.0 is not of type 'integer'"),
        ("import={frames: a.tsv", "config: import: '{frames: a.tsv' is not of type 'object'"),
    ):
        assert line in refused(tmp_path, **parse_config([said]))
