"""The configuration as rules read it: checked, and with every setting of its recipes filled in.

The package defines its settings by dataclasses; all other settings stand in config.schema.yaml.
"""

from dataclasses import asdict
from pathlib import Path

import jsonschema
import yaml

from reference.settings import PROFILES, replaced
from snowsim.settings import CGAN, PHY, TRACKER

SCHEMA = Path(__file__).resolve().parents[1] / "schemas/config.schema.yaml"
# Recipes of each stage by name; the first is the default.
RECIPES = {"reference": PROFILES, "phy": PHY, "cgan": CGAN, "tracker": TRACKER}
NO_FUNCTIONS = {"renderers": {}, "trackers": {}}

# For JSON Schema after draft 4, 4.0 is an integer.
STRICT = jsonschema.validators.extend(
    jsonschema.Draft202012Validator, type_checker=jsonschema.Draft4Validator.TYPE_CHECKER
)


def typed(value, said):
    """A configuration in which nested values of `--config`, `said`, have the types of a file.

    Snakemake reads all of ``--config 'phy={n_looks: 100}'`` as text. What a file says is left
    alone.
    """
    if isinstance(value, dict) and isinstance(said, dict):
        return value | {key: typed(value[key], said[key]) for key in value.keys() & said.keys()}
    if isinstance(value, list) and isinstance(said, list) and len(value) == len(said):
        return [typed(*pair) for pair in zip(value, said, strict=True)]
    if isinstance(value, str) and value == said:
        try:
            read = yaml.load(value, Loader=yaml.CSafeLoader)
        except yaml.YAMLError:  # half a mapping: text, which the schema refuses by its key
            return value
        return read if read is None or isinstance(read, (bool, int, float)) else value
    return value


def filled(config):
    """A configuration with all settings of its recipes; a setting that it names replaces them.

    ValueError of one line for unknown keys, wrong types and impossible values.
    """
    check(config)
    whole = dict(config)
    phy = {"recipe": "measured"} | config["phy"]
    settings = settings_from("phy", *recipe_of("phy", phy))
    whole["phy"] = {"recipe": phy["recipe"], **asdict(settings)}
    trained = {}
    for stage in ("cgan", "tracker"):
        recipe, others = recipe_of(stage, config[stage])
        trained[stage] = settings_from(f"{stage}.training", recipe, others.get("training", {}))
        whole[stage] = others | {"training": asdict(trained[stage])}
    pretrained = config["pretrained"]
    training = settings_from("pretrained.training", trained["tracker"], pretrained["training"])
    whole["pretrained"] = pretrained | {"training": asdict(training)}
    named = config["reference"]
    if isinstance(named, str):
        named = {"recipe": named}
    whole["reference"] = asdict(settings_from("reference", *recipe_of("reference", named)))
    whole["own"] = NO_FUNCTIONS | config.get("own", {})
    return whole


def recipe_of(stage, section):
    """The recipe that a section of the configuration names, or the default, and its other keys."""
    recipes = RECIPES[stage]
    others = dict(section)
    name = others.pop("recipe", None) or next(iter(recipes))
    if name not in recipes:
        key = stage if stage == "reference" else f"{stage}.recipe"
        msg = f"config: {key}: expected {' or '.join(recipes)}, got {name}"
        raise ValueError(msg)
    return recipes[name], others


def settings_from(section, recipe, named):
    """Settings of a recipe, some replaced by those that a section of the configuration names."""
    try:
        return replaced(recipe, named)
    except ValueError as error:
        msg = f"config: {section}: {error}"
        raise ValueError(msg) from None


def read_schema():
    """JSON Schema of a configuration; it knows settings of the package by name, not by limits."""
    schema = yaml.load(SCHEMA.read_text(), Loader=yaml.CSafeLoader)
    schema["properties"]["phy"]["properties"] |= dict.fromkeys(asdict(PHY["measured"]), {})
    return schema


def check(config):
    """ValueError unless the schema accepts a configuration."""
    validator = STRICT(read_schema())
    error = jsonschema.exceptions.best_match(validator.iter_errors(config))
    if error is not None:
        key = ".".join(str(part) for part in error.absolute_path) or "top level"
        expected = error.schema.get("description", "")
        if error.validator == "additionalProperties":
            expected = ", ".join(error.schema["properties"])
        hint = f" (expected: {expected})" if expected else ""
        msg = f"config: {key}: {error.message}{hint}"
        raise ValueError(msg)
