"""The configuration reference, made from the default configuration and its schema."""

import configuration
import yaml
from runs import CONFIG, SCHEMA


def test_every_setting_is_listed_once_with_its_default_and_a_comment():
    settings = configuration.read_settings(configuration.CONFIG.read_text(), SCHEMA)
    assert [setting.path for setting in settings if not setting.comment] == []
    for setting in settings:
        if setting.default:
            value = CONFIG
            for key in setting.path:
                value = value[key]
            assert yaml.safe_load(setting.default) == value, setting.path
    shown = [line for line in configuration.reference().splitlines() if line.startswith("| `")]
    assert len(shown) == len({setting.path for setting in settings if setting.default is not None}) > 180


def test_comments_go_on_in_their_column_and_limits_are_said():
    number = {"type": ["number", "null"], "exclusiveMinimum": 0}
    schema = {"properties": {"s": {"properties": {"a": {"$ref": "#/$defs/n"}}}}, "$defs": {"n": number}}
    text = "s:        # a_* section, `b_*`\n  a: null # [m] length,\n          # measured\n"
    section, setting = configuration.read_settings(text, schema)
    assert (section.comment, section.default) == ("a_* section, `b_*`", None)
    assert r"a\_\* section, `b_*`" in configuration.markdown([section, setting])
    assert (setting.comment, setting.default) == ("[m] length, measured", "null")
    assert setting.accepted == "number above 0 or `null`"
