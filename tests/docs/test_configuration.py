"""Settings are said once: default, schema, dataclasses and the reference made of them agree."""

from dataclasses import asdict, fields
from functools import reduce
from operator import or_

import configuration
import jsonschema
import pytest
import yaml

from snowsim import cgan, tracker
from snowsim.reference.settings import GROUPS

CONFIG = yaml.safe_load(configuration.CONFIG.read_text())
SCHEMA = yaml.safe_load(configuration.SCHEMA.read_text())
SETTINGS = {
    ("cgan", "training"): cgan.Settings,
    ("tracker", "training"): tracker.Settings,
    **{("reference", name): group for name, group in GROUPS.items()},
}
KINDS = {"integer": int, "number": float, "boolean": bool, "array": tuple, "null": None}


@pytest.fixture
def config():
    """The default, to be changed."""
    return yaml.safe_load(configuration.CONFIG.read_text())


def sections(values, schema=SCHEMA, path=()):
    """(path, values, schema) of every section of a configuration."""
    schema = configuration.resolved(schema, SCHEMA)
    yield path, values, schema
    for key, value in values.items():
        if isinstance(value, dict):
            yield from sections(value, schema["properties"][key], (*path, key))


def accepts(config):
    return jsonschema.Draft202012Validator(SCHEMA).is_valid(config)


def kind(part):
    """Type of a setting in the package, from the schema."""
    if "enum" in part:
        return type(part["enum"][0])
    names = part["type"] if isinstance(part["type"], list) else [part["type"]]
    return reduce(or_, [KINDS[name] for name in names])


def at_the_limits(part):
    """Values of a setting that the schema just accepts, and ones that it just refuses."""
    step = 1 if part.get("type") == "integer" else 1e-9
    inside = part.get("enum", []) + [part[key] for key in ("minimum", "maximum") if key in part]
    outside = ["none of these"] if "enum" in part else []
    outside += [part[key] + step * sign for key, sign in (("minimum", -1), ("maximum", 1)) if key in part]
    for key, sign in (("exclusiveMinimum", 1), ("exclusiveMaximum", -1)):
        if key in part:
            inside.append(part[key] + sign * step)
            outside.append(part[key])
    return inside, outside


def test_the_schema_is_one_and_accepts_the_default(config):
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    assert accepts(config)


def test_every_key_of_the_default_is_required_and_no_other_is_known():
    for path, values, schema in sections(CONFIG):
        assert schema["additionalProperties"] is False, path
        if path != ("studies", "cgan", "stability", "training"):  # holds what differs from cgan.training
            assert list(values) == list(schema["properties"]) == schema["required"], path


def test_the_schema_refuses_what_its_limits_exclude(config):
    n_limits = 0
    for path, values, schema in sections(config):
        for key in values:
            kept = values[key]
            inside, outside = at_the_limits(configuration.resolved(schema["properties"][key], SCHEMA))
            for value in [*inside, *outside, {"a": 1}]:
                values[key] = value
                assert accepts(config) == (value in inside), (*path, key, value)
            values[key] = kept
            n_limits += len(outside)
    assert n_limits > 150


@pytest.mark.parametrize("path", SETTINGS, ids=".".join)
def test_defaults_types_and_limits_of_the_package_are_those_of_the_configuration(path):
    section, name = path
    settings, given = SETTINGS[path], CONFIG[section][name]
    schema = configuration.resolved(SCHEMA["properties"][section]["properties"][name], SCHEMA)
    assert asdict(settings()) == asdict(settings(**given))
    assert [f.name for f in fields(settings)] == list(given)
    for field in fields(settings):
        part = configuration.resolved(schema["properties"][field.name], SCHEMA)
        assert field.type == kind(part), field.name
        inside, outside = at_the_limits(part)
        if section == "reference":  # within the limits, settings of the flight also limit each other
            inside = []
        elif "enum" not in part:  # of networks the package refuses only what cannot be computed
            outside = []
        for value in inside:
            settings(**given | {field.name: value})
        for value in outside:
            with pytest.raises(ValueError, match=field.name):
                settings(**given | {field.name: value})


def test_every_setting_is_listed_once_with_its_default_and_a_comment():
    listed = configuration.read_settings(configuration.CONFIG.read_text(), SCHEMA)
    defaults = {setting.path: setting.default for setting in listed if setting.default}
    for path, values, _ in sections(CONFIG):
        for key, value in values.items():
            if (*path, key) in defaults:
                assert yaml.safe_load(defaults[(*path, key)]) == value
    assert all(setting.comment for setting in listed), [s.path for s in listed if not s.comment]
    rows = [line for line in configuration.reference().splitlines() if line.startswith("| `")]
    assert len(rows) == len({setting.path for setting in listed if setting.default is not None}) > 180


def test_a_description_stands_in_the_schema_only_where_the_default_shows_none():
    for path, values, schema in sections(CONFIG):
        shown = [key for key in values if "description" in schema["properties"][key]]
        assert shown in ([], ["description"]), path  # import.description says what its pattern means


def test_comments_go_on_in_their_column_and_limits_are_said():
    number = {"type": ["number", "null"], "exclusiveMinimum": 0}
    schema = {"properties": {"s": {"properties": {"a": {"$ref": "#/$defs/n"}}}}, "$defs": {"n": number}}
    text = "s:        # a_* section, `b_*`\n  a: null # [m] length,\n          # measured\n"
    section, setting = configuration.read_settings(text, schema)
    assert (section.comment, section.default) == ("a_* section, `b_*`", None)
    assert r"a\_\* section, `b_*`" in configuration.markdown([section, setting])
    assert (setting.comment, setting.default) == ("[m] length, measured", "null")
    assert setting.accepted == "number above 0 or `null`"
