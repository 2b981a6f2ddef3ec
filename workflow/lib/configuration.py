"""The configuration as rules read it: recipes and the profile of the flight filled in.

The settings of the package, with their limits and recipes, are read from a file that
docs/configuration.py makes of their dataclasses: no start of the workflow imports the package.
"""

import json
from pathlib import Path

import yaml

SCHEMAS = Path(__file__).resolve().parents[1] / "schemas"


def stages():
    """Settings of the package by stage: their `properties`, and every recipe in full."""
    return json.loads((SCHEMAS / "settings.json").read_text())


def whole_schema():
    """JSON Schema of a configuration that is filled in."""
    text = (SCHEMAS / "config.schema.yaml").read_text()
    schema = yaml.load(text, Loader=yaml.CSafeLoader)
    for stage, told in stages().items():
        part = schema["properties"][stage]
        part["properties"] |= told["properties"]
        part["required"] += told["properties"]
        if "training" in told["properties"]:
            schema["$defs"][f"{stage}_training"] = told["properties"]["training"] | {"required": []}
    return schema


def filled(config):
    """A configuration with all settings of its recipes; single ones that it names win.

    ValueError for a recipe that is not known.
    """
    whole = dict(config)
    for stage, told in stages().items():
        given = config.get(stage, {})
        if stage == "reference" and isinstance(given, str):
            given = {"recipe": given}
        if isinstance(given, dict):
            whole[stage] = _merged(_recipe(stage, given, told["recipes"]), given)
    return whole


def _recipe(stage, given, recipes):
    """The recipe that a stage names, by default the first."""
    name = given.get("recipe", next(iter(recipes)))
    if name not in recipes:
        key = stage if stage == "reference" else f"{stage}.recipe"
        msg = f"config: {key}: expected {' or '.join(recipes)}, got {name}"
        raise ValueError(msg)
    return recipes[name]


def _merged(recipe, given):
    """A recipe with what is given in its place; the name of the recipe is left out."""
    merged = dict(recipe)
    for key, value in given.items():
        if isinstance(value, dict) and isinstance(merged.get(key), dict):
            value = _merged(merged[key], value)
        if key != "recipe":
            merged[key] = value
    return merged
