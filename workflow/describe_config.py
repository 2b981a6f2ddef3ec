"""The page config/README.md, from the schema and the default: python workflow/describe_config.py > config/README.md."""

import json
import sys
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[1]
HEAD = """\
# Configuration

`config.yaml` is the default and holds every key; the other files hold what differs and are given after it:

```bash
snakemake --cores 2 --configfile config/config.yaml config/tiny.yaml
```

Keys that are not listed here, and values outside the ranges, are refused before any job starts. Plain values at the top
can be set with `--config seed=7`; nested ones need a file of their own.

Files in this folder: {files}.

This page is made from `workflow/schemas/config.schema.json` and `config.yaml` by `workflow/describe_config.py`.
"""


def default_of(config, keys):
    """What config.yaml holds under a chain of keys, as it is written in YAML."""
    for key in keys:
        config = config[key]
    return json.dumps(config)


def type_of(schema):
    """Type and values a key may have, in words."""
    if "enum" in schema:
        return ", ".join(f"`{json.dumps(value)}`" for value in schema["enum"])
    kinds = schema.get("type", "any")
    return " or ".join([kinds] if isinstance(kinds, str) else kinds)


def sections(schema, config, keys=()):
    """Lines of a section: its description, a table of its plain keys, then the sections inside it."""
    properties = schema.get("properties", {})
    plain = {key: value for key, value in properties.items() if "properties" not in value}
    if keys:
        yield from ("", f"{'#' * min(len(keys) + 1, 6)} `{'.'.join(keys)}`", "", schema.get("description", ""))
    if plain:
        yield from ("", "| key | type or values | default | meaning |", "|---|---|---|---|")
        for key, value in plain.items():
            meaning = value.get("description", "").replace("|", "\\|")
            yield f"| `{key}` | {type_of(value)} | `{default_of(config, (*keys, key))}` | {meaning} |"
    for key, value in properties.items():
        if key not in plain:
            yield from sections(value, config, (*keys, key))


def describe():
    """The page as text."""
    schema = json.loads((ROOT / "workflow/schemas/config.schema.json").read_text())
    config = yaml.safe_load((ROOT / "config/config.yaml").read_text())
    files = ", ".join(f"`{path.name}`" for path in sorted((ROOT / "config").glob("*.yaml")))
    return HEAD.format(files=files) + "\n".join(sections(schema, config)) + "\n"


if __name__ == "__main__":
    sys.stdout.write(describe())
