"""The configuration as Markdown tables, from its schema and the comments of config/config.yaml.

``python docs/configuration.py > config/README.md`` writes the page of that folder; the documentation takes the tables
in when it is built.
"""

import json
import re
import sys
from dataclasses import dataclass
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[1]
CONFIG = ROOT / "config/config.yaml"
SCHEMA = ROOT / "workflow/schemas/config.schema.json"

WORDS = {
    "integer": "whole number",
    "string": "text",
    "boolean": "true or false",
    "array": "list",
    "object": "mapping",
    "null": "`null`",
}

PAGE = """\
# Configuration

`config.yaml` is the default and holds every key; the other files hold what differs and are given after it:

```bash
snakemake --cores 2 --configfile config/config.yaml config/tiny.yaml
```

Keys that are not listed here, and values outside the ranges, are refused before any job starts. Plain values at the top
can be set with `--config seed=7`; nested ones need a file of their own. `examples/` holds a worked configuration for
each source of data. This page is made by `docs/configuration.py`.

"""

BOUNDS = {"minimum": "at least", "exclusiveMinimum": "above", "maximum": "at most", "exclusiveMaximum": "below"}


@dataclass(frozen=True)
class Setting:
    """One key of the configuration, or a section of them.

    Attributes
    ----------
    path : tuple of str
        Keys from the top level down.
    default : str or None
        As written in the file; None for a section.
    comment : str
        What stands beside it in the file: unit, meaning, source.
    description : str
        What the schema says of it.
    accepted : str
        What the schema accepts; empty for a section.
    """

    path: tuple
    default: str | None
    comment: str
    description: str
    accepted: str


def read_settings(config=CONFIG, schema=SCHEMA):
    """All settings of the configuration, in the order of the file.

    Raises
    ------
    ValueError
        If the file holds a key that the schema does not describe, or lacks one that it requires.
    """
    text = Path(config).read_text()
    settings = list(_settings(yaml.compose(text), json.loads(Path(schema).read_text()), (), text.splitlines()))
    return settings


def markdown(settings, level=2):
    """Tables of settings, one a section, under headings of this level and below."""
    top = [setting for setting in settings if len(setting.path) == 1 and setting.default is not None]
    parts = [_table(top)] if top else []
    for section in (setting for setting in settings if setting.default is None):
        held = [s for s in settings if s.path[:-1] == section.path and s.default is not None]
        parts.append(f"{'#' * (level + len(section.path) - 1)} {'.'.join(section.path)}")
        parts.append(_plain(section.comment or section.description))
        if held:
            parts.append(_table(held))
    return "\n\n".join(part for part in parts if part) + "\n"


def _settings(node, schema, path, lines):
    """Settings of a mapping of the parsed file, its sections first said, then gone into."""
    described = schema.get("properties", {})
    keys = [key.value for key, _ in node.value]
    missing = [key for key in schema.get("required", []) if key not in keys]
    if missing:
        msg = f"{CONFIG.name}: {'.'.join(path) or 'top level'}: expected key {missing[0]}, which the schema requires"
        raise ValueError(msg)
    for key, value in node.value:
        here = (*path, key.value)
        if key.value not in described:
            msg = f"{CONFIG.name}: {'.'.join(here)}: no such key in the schema"
            raise ValueError(msg)
        part = described[key.value]
        is_section = isinstance(value, yaml.MappingNode) and "properties" in part
        comment = _comment(key.start_mark.line if is_section else value.end_mark.line, key.start_mark.line, lines)
        default = None if is_section else _source(value, lines)
        accepted = "" if is_section else _accepted(part)
        yield Setting(here, default, comment, part.get("description", ""), accepted)
        if is_section:
            yield from _settings(value, part, here, lines)


def _accepted(part):
    """Types, choices and bounds of one key of the schema in words."""
    if "enum" in part:
        return " or ".join(f"`{json.dumps(choice).strip(chr(34))}`" for choice in part["enum"])
    types = part.get("type", [])
    types = [types] if isinstance(types, str) else types
    if {"minimum", "maximum"} <= set(part):
        bounds = f"from {part['minimum']:g} to {part['maximum']:g}"
    else:
        bounds = " and ".join(f"{word} {part[key]:g}" for key, word in BOUNDS.items() if key in part)
    words = [WORDS.get(name, name) + (f" {bounds}" if bounds and name != "null" else "") for name in types]
    each = f", each {_accepted(part['items'])}" if "items" in part else ""
    return " or ".join(words) + each


def _source(value, lines):
    """A value as it is written, on one line."""
    if isinstance(value, yaml.ScalarNode):
        return value.value if value.style is None else repr(value.value)
    if value.flow_style:
        first, last = value.start_mark, value.end_mark
        if first.line == last.line:
            return lines[first.line][first.column : last.column]
    return json.dumps(yaml.safe_load(yaml.serialize(value)))


def _comment(line, first_line, lines):
    """The comment behind a key, with the lines that continue it in the same column."""
    line = line if line < len(lines) and "#" in lines[line] else first_line
    code, mark, comment = lines[line].partition(" #")
    if not mark:
        return ""
    parts, column = [comment.strip()], len(code) + 1
    for further in lines[line + 1 :]:
        if not further.strip().startswith("#") or further.find("#") != column:
            break
        parts.append(further.strip().lstrip("#").strip())
    return " ".join(parts)


def _table(settings):
    rows = ["| setting | default | accepted | unit, meaning, source |", "|---|---|---|---|"]
    for setting in settings:
        cells = (
            f"`{setting.path[-1]}`",
            f"`{setting.default}`",
            setting.accepted,
            _plain(setting.comment or setting.description),
        )
        rows.append("| " + " | ".join(cells) + " |")
    return "\n".join(rows)


def _plain(text):
    """Text whose signs mean nothing to Markdown, but for what stands between backquotes."""
    parts = text.split("`")
    parts[::2] = [re.sub(r"([*_<|\\])", r"\\\1", part) for part in parts[::2]]
    return "`".join(parts)


if __name__ == "__main__":
    sys.stdout.write(PAGE + markdown(read_settings()))
