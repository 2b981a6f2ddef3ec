"""The configuration reference as Markdown: defaults and comments, what the schema accepts.

``python docs/configuration.py`` prints it; the documentation takes it in when it is built.
"""

import json
import re
import sys
from pathlib import Path
from typing import NamedTuple

import yaml

ROOT = Path(__file__).resolve().parents[1]
CONFIG = ROOT / "config/config.yaml"
SCHEMA = ROOT / "workflow/schemas/config.schema.yaml"

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
        described = resolved(part["properties"][key.value], schema)
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


def reference():
    """The whole reference."""
    return markdown(read_settings(CONFIG.read_text(), yaml.safe_load(SCHEMA.read_text())))


if __name__ == "__main__":
    sys.stdout.write(reference())
