"""The configuration reference, made from the schema and the comments of config.yaml."""

import json

import configuration
import pytest
import yaml


def leaves(schema, config, path=()):
    """Paths of settings: all that the schema requires, and of those it leaves open the ones in the file."""
    for key, part in schema.get("properties", {}).items():
        if key not in schema.get("required", []) and key not in config:
            continue
        if isinstance(config[key], dict) and "properties" in part:
            yield from leaves(part, config[key], (*path, key))
        else:
            yield (*path, key)


def test_every_key_of_the_schema_is_listed_with_its_default_and_a_comment():
    listed = {s.path: s for s in configuration.read_settings() if s.default is not None}
    config = yaml.safe_load(configuration.CONFIG.read_text())
    assert set(listed) == set(leaves(json.loads(configuration.SCHEMA.read_text()), config))
    for path, setting in listed.items():
        value = config
        for key in path:
            value = value[key]
        assert yaml.safe_load(setting.default) == value
        assert setting.comment or setting.description, path
        assert setting.accepted, path


def test_tables_hold_each_setting_once():
    settings = [s for s in configuration.read_settings() if s.default is not None]
    rows = [line for line in configuration.markdown(settings).splitlines() if line.startswith("| `")]
    assert len(rows) == len([s for s in settings if len(s.path) == 1])
    everything = configuration.markdown(configuration.read_settings())
    assert sum(line.startswith("| `") for line in everything.splitlines()) == len(settings)


def test_a_key_without_description_and_a_missing_key_are_refused(tmp_path):
    schema = tmp_path / "schema.json"
    part = {"type": "object", "required": ["a"], "properties": {"a": {"type": "integer", "minimum": 1}}}
    schema.write_text(json.dumps(part))
    config = tmp_path / "config.yaml"
    config.write_text("a: 1   # [m] length\nb: 2\n")
    with pytest.raises(ValueError, match=r"b: no such key"):
        configuration.read_settings(config, schema)
    config.write_text("{}\n")
    with pytest.raises(ValueError, match=r"expected key a"):
        configuration.read_settings(config, schema)


def test_comments_go_on_in_their_column_and_bounds_are_said(tmp_path):
    schema = tmp_path / "schema.json"
    part = {"properties": {"s": {"properties": {"a": {"type": ["number", "null"], "exclusiveMinimum": 0}}}}}
    schema.write_text(json.dumps(part))
    config = tmp_path / "config.yaml"
    config.write_text("s:        # a_* section, `b_*`\n  a: null # [m] length,\n          # measured\n")
    section, setting = configuration.read_settings(config, schema)
    assert (section.comment, section.default) == ("a_* section, `b_*`", None)
    assert r"a\_\* section, `b_*`" in configuration.markdown([section, setting])
    assert (setting.comment, setting.default) == ("[m] length, measured", "null")
    assert setting.accepted == "number above 0 or `null`"


def test_the_page_of_the_config_folder_is_up_to_date():
    # Made by `python docs/configuration.py > config/README.md`, again after each change of schema or config.yaml.
    page = configuration.ROOT / "config/README.md"
    assert page.read_text() == configuration.PAGE + configuration.markdown(configuration.read_settings())
