"""A wrong configuration stops before any job; default, schema and package say the same."""

import re
from copy import deepcopy
from dataclasses import fields
from inspect import signature

import configuration
import pytest
import yaml
from configuration import resolved
from jsonschema import Draft202012Validator
from runs import CONFIG, SCHEMA, lines_with, parsed, refused, run_snakemake, settings, text_of

from lib.configuration import filled, stages
from lib.imports import ROOT
from snowsim import cgan, tracker
from snowsim.labels import prepare
from snowsim.labels.settings import Settings as LabelSettings
from snowsim.phy.settings import Settings as PhySettings
from snowsim.reference.settings import GROUPS

# Dataclasses of the package whose fields are settings.
SETTINGS = [
    cgan.Settings,
    tracker.Settings,
    LabelSettings,
    PhySettings,
    *GROUPS.values(),
]


def sections(values, schema=SCHEMA, path=()):
    """(path, values, schema) of every section of a configuration, references resolved."""
    schema = resolved(schema, SCHEMA)
    properties = {key: resolved(part, SCHEMA) for key, part in schema["properties"].items()}
    schema = schema | {"properties": properties}
    yield path, values, schema
    for key, value in values.items():
        if isinstance(value, dict):
            yield from sections(value, properties[key], (*path, key))


def at_the_limits(part):
    """Values of a setting that the schema just accepts, and ones that it just refuses."""
    step = 1 if part.get("type") == "integer" else 1e-9
    inside = []
    outside = []
    if "enum" in part:
        inside += part["enum"]
        outside.append("none of these")
    for key, outwards in (("minimum", -step), ("maximum", step)):
        if key in part:
            inside.append(part[key])
            outside.append(part[key] + outwards)
    for key, inwards in (("exclusiveMinimum", step), ("exclusiveMaximum", -step)):
        if key in part:
            inside.append(part[key] + inwards)
            outside.append(part[key])
    return inside, outside


def test_every_key_of_the_default_is_required_and_no_other_is_known():
    for path, values, schema in sections(CONFIG):
        assert schema["additionalProperties"] is False, path
        if path == ("pretrained", "training"):
            continue  # what differs from tracker.training
        # Others of its study hold what differs from cgan.training.
        if path[:2] != ("studies", "cgan") or path[-1] in ("cgan", "atlas"):
            keys = sorted(values)
            assert keys == sorted(schema["properties"]) == sorted(schema["required"]), path


def test_the_schema_accepts_the_default_and_refuses_what_its_limits_exclude():
    Draft202012Validator.check_schema(SCHEMA)
    accepts = Draft202012Validator(SCHEMA).is_valid
    config = deepcopy(CONFIG)
    n_limits = 0
    assert accepts(config)
    for path, values, schema in sections(config):
        for key, default in list(values.items()):
            inside, outside = at_the_limits(schema["properties"][key])
            for value in [*inside, *outside, {"unheard_of": 1}]:
                values[key] = value
                assert accepts(config) == (value in inside), (*path, key, value)
            values[key] = default
            n_limits += len(outside)
    assert n_limits > 150


def leaves(values):
    """How many values of a parsed file are no mapping; a list counts once."""
    return sum(map(leaves, values.values())) if isinstance(values, dict) else 1


def test_the_default_names_what_a_user_turns_and_no_setting_of_a_recipe():
    written = yaml.safe_load(configuration.CONFIG.read_text())
    assert leaves(written) <= 110
    for stage, told in stages().items():
        if isinstance(written[stage], dict):
            assert set(written[stage]) & set(told["properties"]) == set(), stage
            assert written[stage]["recipe"] == next(iter(told["recipes"]))
        else:
            assert written[stage] in told["recipes"]


def test_the_schema_of_the_package_s_settings_is_made_from_their_dataclasses():
    made = configuration.settings_text()
    assert configuration.SETTINGS.read_text() == made, "python docs/configuration.py settings"
    described = [
        part["description"]
        for _, _, schema in sections(CONFIG)
        for part in schema["properties"].values()
        if "description" in part
    ]
    assert len(described) > 120
    assert all(described)


@pytest.mark.parametrize("group", SETTINGS)
def test_the_package_refuses_what_the_schema_of_its_settings_excludes(group):
    for each in fields(group):
        inside, outside = at_the_limits(dict(each.metadata))
        # Settings of the flight also limit each other.
        for value in inside if group not in GROUPS.values() else []:
            group(**{each.name: value})
        for value in outside:
            with pytest.raises(ValueError, match=each.name):
                group(**{each.name: value})


def test_the_default_recipes_are_those_of_the_package():
    drawn = signature(prepare).parameters
    for each in fields(LabelSettings):
        if each.name in drawn:
            assert drawn[each.name].default == each.default, each.name
    assert tracker.Settings(**CONFIG["tracker"]["training"]) == tracker.Settings()
    statistics = CONFIG["cgan"]["statistics"]
    assert cgan.Settings(**CONFIG["cgan"]["training"], statistics=statistics) == cgan.Settings()


def test_a_setting_named_beside_a_recipe_wins_and_the_rest_is_the_recipe_s():
    given = {
        "labels": {"recipe": "paper", "surface": "measured"},
        "cgan": {"recipe": "paper", "training": {"width": 3}},
        "reference": {"climate": {"accumulation_factor": 0.5}},
    }
    made = filled(given)
    assert made["labels"]["surface"] == "measured"
    assert made["labels"]["n_layers"] == "uniform"
    assert made["cgan"]["training"]["width"] == 3
    assert made["cgan"]["training"]["method"] == "pix2pix"
    factor = {"accumulation_factor": 0.5}
    climate = CONFIG["reference"]["climate"] | factor
    assert made["reference"] == CONFIG["reference"] | {"climate": climate}
    assert filled({"reference": "greenland_2012"})["reference"] == CONFIG["reference"]


def test_a_configuration_that_names_every_setting_means_what_it_says():
    changed = deepcopy(CONFIG)
    changed["phy"]["align"] = "gaussian"
    assert filled(changed) == changed
    assert Draft202012Validator(SCHEMA).is_valid(changed)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("sead: 7", "sead"),
        ("labels: {n_scene: 3}", "labels: .*n_scene.*expected: n_scenes"),
        ("phy: {recipe: papers}", "phy.recipe: expected measured or paper, got papers"),
        (
            "tracker: {training: {optimiser: sgd, loss: sigmoids}}",
            "expected: tracker.training.network: published, in place of optimiser, loss",
        ),
        ("reference: antarctica", "reference: expected greenland_2012, got antarctica"),
        ("reference: {climate: {snow: 1}}", "reference.climate: .*'snow' was unexpected"),
        (
            "studies: {cgan: {stability: {}}}",
            r"studies\.cgan: .*'stability' was unexpected.*\(expected: .*atlas\)",
        ),
        ("labels: {n_layers_min: 9, n_layers_max: 6}", "labels.n_layers_min: expected at most"),
        ("labels: {n_zones: 4}", "labels: .*n_zones.*expected: n_scenes"),
        ("phy: {tolerance_db: -1}", "phy.tolerance_db: -1 "),
        ('import: {description: "a\\nb"}', "import.description: .*expected: one line"),
        (
            "flight: {n_frames: 9999}",
            r"flight\.n_frames: expected frames that fit on the line of 1\d\d\d km",
        ),
        (
            "reference: {firn: {horizon_jump_kg_m3: 600.0}}",
            r"reference\.firn\.horizon_jump_kg_m3 must be at most 577",
        ),
        (
            "reference: {radar: {n_range_bins: 210}}",
            r"reference\.radar\.n_range_bins must be at least 2[23]\d",
        ),
    ],
)
def test_a_bad_key_is_named_in_one_line(tmp_path, text, expected):
    assert re.search(f"^config: .*{expected}", refused(tmp_path, **yaml.safe_load(text)))


def test_a_bad_key_in_a_file_or_a_command_stops_a_run_in_one_line_and_nothing_is_written(tmp_path):
    configs = settings(tmp_path, "lables: {n_scenes: 3}")
    in_file = run_snakemake(tmp_path / "run", "--dry-run", configs=configs, fails=True)
    in_command = run_snakemake(tmp_path / "run", "--dry-run", "--config", "seed=seven", fails=True)
    (of_file,) = lines_with(in_file, "config: ")
    assert re.search("lables.*expected: seed, source, import", of_file), of_file
    (of_command,) = lines_with(in_command, "config: ")
    assert re.search("seed", of_command), of_command
    assert not (tmp_path / "run/results").exists()


@pytest.mark.parametrize(
    "configs", [("config.yaml", "paper.yaml"), ("config.yaml", "as_printed.yaml", "paper.yaml")]
)
def test_the_dag_of_the_paper_s_scale_builds(tmp_path, configs):
    run_snakemake(tmp_path, "--dry-run", "--quiet", configs=configs)


def test_the_configuration_of_the_paper_s_scale_needs_no_default_beside_it(tmp_path):
    alone = parsed(tmp_path, ("paper.yaml",))
    beside = parsed(tmp_path, ("config.yaml", "paper.yaml"))
    assert alone.globals["config"] == beside.globals["config"]


def test_the_run_as_printed_shares_flight_and_benchmark_alone(tmp_path):
    done = run_snakemake(tmp_path, "--dry-run", "--", "as_printed")
    missing = re.findall(r"Missing output files: ([^;\n]*)", text_of(done))
    files = {file for line in missing for file in line.split(", ")}
    shared = {file.split("/")[1] for file in files if not file.startswith("results/as_printed/")}
    assert shared == {"flight", "benchmark", "statistics"}  # of the last the sums over frames
    assert "results/as_printed/statistics.nc" in files
    assert "results/as_printed/tables/table3_intervals.csv" in files


def test_what_is_printed_otherwise_stands_among_the_departures():
    printed = filled(yaml.safe_load((ROOT / "config/as_printed.yaml").read_text()))
    text = (ROOT / "docs/stages/choices.md").read_text()
    after = text.split("## Where the default departs from the paper")[1]
    departures = after.split("\n## ")[0]
    for section, changes in printed.items():
        for key, value in changes.items():
            if value != CONFIG[section][key]:
                assert re.search(rf"\b{key}\b", departures), f"{section}.{key}"
