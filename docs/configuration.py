"""The configuration reference as Markdown: defaults and comments of config/config.yaml, what its schema accepts.

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
    """One key of the configuration: its path and default as written; of a section, the default is None."""

    path: tuple
    default: str | None
    accepted: str
    comment: str


def read_settings(text, schema):
    """All settings of a YAML text in its order; keys that only the schema knows follow the list they belong to."""
    return list(_settings(yaml.compose(text), schema, (), text, schema))


def markdown(settings):
    """A table for each section, under a heading of its own."""
    parts = [
        _table(
            [
                setting
                for setting in settings
                if len(setting.path) == 1 and setting.default is not None
            ]
        )
    ]
    for section in (setting for setting in settings if setting.default is None):
        held = [s for s in settings if s.path[:-1] == section.path and s.default is not None]
        parts += [
            f"{'#' * (len(section.path) + 1)} {'.'.join(section.path)}",
            _plain(section.comment),
        ]
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
        return " or ".join(f"`{json.dumps(choice).strip(chr(34))}`" for choice in part["enum"])
    types = part.get("type", [])
    bounds = " and ".join(f"{word} {part[key]:g}" for key, word in BOUNDS.items() if key in part)
    words = [
        WORDS.get(name, name) + (f" {bounds}" if bounds and name != "null" else "")
        for name in ([types] if isinstance(types, str) else types)
    ]
    return " or ".join(words) + (f", each {accepted(part['items'])}" if "items" in part else "")


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
            for name, item in described["items"]["properties"].items():
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
    rows = [
        f"| `{s.path[-1]}` | {f'`{s.default}`' if s.default else ''} | {s.accepted} | {_plain(s.comment)} |"
        for s in settings
    ]
    return "\n".join(
        ["| setting | default | accepted | unit, meaning, source |", "|---|---|---|---|", *rows]
    )


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
