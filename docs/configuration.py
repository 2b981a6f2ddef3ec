"""The configuration reference as Markdown, and the part of the schema that dataclasses hold.

``python docs/configuration.py`` prints the page; the documentation takes it in when it is built.
``python docs/configuration.py settings`` writes workflow/schemas/settings.json: settings of the
package with limits, unit, meaning and source, and their recipes, all from the dataclasses.
"""

import json
import re
import sys
from dataclasses import asdict, fields
from pathlib import Path
from typing import NamedTuple, get_args

import yaml

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "workflow")]

from lib.configuration import stages, whole_schema  # noqa: E402

CONFIG = ROOT / "config/config.yaml"
SETTINGS = ROOT / "workflow/schemas/settings.json"
KINDS = {int: "integer", float: "number", bool: "boolean", tuple: "array", type(None): "null"}

WORDS = {
    "integer": "whole number",
    "string": "text",
    "boolean": "true or false",
    "array": "list",
    "object": "mapping",
    "null": "`null`",
}
BOUNDS = {
    "minimum": "at least",
    "exclusiveMinimum": "above",
    "maximum": "at most",
    "exclusiveMaximum": "below",
}


class Setting(NamedTuple):
    """One key: its path, its default as written (None of a section), accepted values, comment."""

    path: tuple
    default: str | None
    accepted: str
    comment: str


def read_settings(text, schema):
    """All settings of a YAML text in its order; keys of the schema alone follow their list."""
    return list(_settings(yaml.compose(text), schema, (), text, schema))


def markdown(settings):
    """A table for each section, under a heading of its own."""
    keys = [setting for setting in settings if setting.default is not None]
    parts = [_table([key for key in keys if len(key.path) == 1])]
    for section in settings:
        if section.default is not None:
            continue
        level = "#" * (len(section.path) + 1)
        parts.append(f"{level} {'.'.join(section.path)}")
        parts.append(_plain(section.comment))
        held = [key for key in keys if key.path[:-1] == section.path]
        if held:
            parts.append(_table(held))
    return "\n\n".join(part for part in parts if part) + "\n"


def resolved(part, schema):
    """A part of the schema with what it refers to put in."""
    while "$ref" in part:
        target = schema
        for key in part["$ref"].removeprefix("#/").split("/"):
            target = target[key]
        part = target | {key: value for key, value in part.items() if key != "$ref"}
    return part


def accepted(part):
    """Types, choices and bounds of one key of the schema in words."""
    if "enum" in part:
        choices = [json.dumps(choice).strip('"') for choice in part["enum"]]
        return " or ".join(f"`{choice}`" for choice in choices)
    types = part.get("type", [])
    bounds = " and ".join(f"{word} {part[key]:g}" for key, word in BOUNDS.items() if key in part)
    kinds = []
    for name in [types] if isinstance(types, str) else types:
        kind = WORDS.get(name, name)
        if bounds and name != "null":
            kind += f" {bounds}"
        kinds.append(kind)
    words = " or ".join(kinds)
    return f"{words}, each {accepted(part['items'])}" if "items" in part else words


def _settings(node, part, path, text, schema):
    for key, value in node.value:
        here = (*path, key.value)
        described = _described(part, key.value, here, schema)
        is_block = isinstance(value, yaml.CollectionNode) and not value.flow_style
        comment = _comment((key if is_block else value).end_mark.line, text.splitlines())
        if not is_block:
            source = text[value.start_mark.index : value.end_mark.index]
            yield Setting(here, " ".join(source.split()), accepted(described), comment)
            continue
        yield Setting(here, None, "", comment)
        if isinstance(value, yaml.MappingNode):
            yield from _settings(value, described, here, text, schema)
        else:
            for name, item in resolved(described["items"], schema)["properties"].items():
                item = resolved(item, schema)
                yield Setting((*here, name), "", accepted(item), item["description"])


def _described(part, key, path, schema):
    """What the schema says of a key; of a recipe, or the profile of the flight, its names."""
    if key == "recipe" or path == ("reference",):
        return {"enum": list(stages()[path[0]]["recipes"])}
    return resolved(part["properties"][key], schema)


def _comment(line, lines):
    """The comment on a line, with the lines below that continue it in the same column."""
    code, mark, comment = lines[line].partition(" #")
    parts = [comment.strip()] if mark else []
    for further in lines[line + 1 :]:
        if not mark or not further.strip().startswith("#") or further.find("#") != len(code) + 1:
            break
        parts.append(further.strip().lstrip("# "))
    return " ".join(parts)


def _table(settings):
    lines = ["| setting | default | accepted | unit, meaning, source |", "|---|---|---|---|"]
    for setting in settings:
        default = f"`{setting.default}`" if setting.default else ""
        cells = [f"`{setting.path[-1]}`", default, setting.accepted, _plain(setting.comment)]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def _plain(text):
    """Text whose signs mean nothing to Markdown, but for what stands between backquotes."""
    parts = text.split("`")
    parts[::2] = [re.sub(r"([*_<|\\])", r"\\\1", part) for part in parts[::2]]
    return "`".join(parts)


def recipe_settings(stage, told):
    """Settings of the recipes of a stage: the first one's values, and where others differ."""
    path = (f"Recipes of {stage}",)
    yield Setting(path, None, "", f"Recipes: `{'`, `'.join(told['recipes'])}`.")
    yield from _of_recipe(told["properties"], told["recipes"], path)


def _of_recipe(properties, recipes, path):
    first, *others = recipes.values()
    for key, part in properties.items():
        if "properties" in part:
            here = (*path, key)
            yield Setting(here, None, "", "")
            inner = {name: recipe[key] for name, recipe in recipes.items()}
            yield from _of_recipe(part["properties"], inner, here)
            continue
        default = json.dumps(first[key]).strip('"')
        names = list(recipes)[1:]
        for name, other in zip(names, others, strict=True):
            if other[key] != first[key]:
                default += f"`; {name}: `{json.dumps(other[key])}".replace('"', "")
        yield Setting((*path, key), default, accepted(part), part["description"])


def reference():
    """The whole reference."""
    settings = read_settings(CONFIG.read_text(), whole_schema())
    for stage, told in stages().items():
        settings += recipe_settings(stage, told)
    return markdown(settings)


def part_of(settings):
    """The part of the schema for a dataclass of settings."""
    properties = {each.name: _property(each) for each in fields(settings)}
    closed = {"type": "object", "additionalProperties": False}
    return closed | {"required": list(properties), "properties": properties}


def _property(each):
    limits = dict(each.metadata)
    part = {"description": limits.pop("about")}
    if "enum" not in limits:
        kinds = [KINDS[kind] for kind in get_args(each.type) or (each.type,)]
        part["type"] = kinds if len(kinds) > 1 else kinds[0]
    return part | limits


def package_settings():
    """All settings of the package by stage, as workflow/schemas/settings.json has them."""
    from snowsim import cgan, tracker
    from snowsim.cgan.settings import RECIPES as CGAN
    from snowsim.labels.settings import RECIPES as LABELS
    from snowsim.phy.settings import RECIPES as PHY
    from snowsim.reference.settings import GROUPS, PROFILES
    from snowsim.tracker.settings import RECIPES as TRACKER

    whole = {}
    for stage, recipes in {"labels": LABELS, "phy": PHY}.items():
        properties = part_of(recipes["measured"])["properties"]
        told = {name: asdict(recipe) for name, recipe in recipes.items()}
        whole[stage] = {"properties": properties, "recipes": told}
    # How features are normalised is of the network, not of its training alone.
    training = part_of(cgan.Settings)
    training["required"].remove("statistics")
    statistics = training["properties"].pop("statistics")
    told = {}
    for name, recipe in CGAN.items():
        values = asdict(recipe)
        told[name] = {"statistics": values.pop("statistics"), "training": values}
    properties = {"statistics": statistics, "training": training}
    whole["cgan"] = {"properties": properties, "recipes": told}
    told = {name: {"training": asdict(recipe)} for name, recipe in TRACKER.items()}
    whole["tracker"] = {"properties": {"training": part_of(tracker.Settings)}, "recipes": told}
    groups = {name: part_of(group) for name, group in GROUPS.items()}
    told = {name: asdict(profile) for name, profile in PROFILES.items()}
    whole["reference"] = {"properties": groups, "recipes": told}
    return whole


def settings_text():
    """What stands in workflow/schemas/settings.json."""
    return json.dumps(package_settings(), indent=1) + "\n"


if __name__ == "__main__":
    if sys.argv[1:] == ["settings"]:
        SETTINGS.write_text(settings_text())
    else:
        sys.stdout.write(reference())
