"""A page from templates, and the small text files that go into one."""

import json
from pathlib import Path

import jinja2
import pandas as pd
import yaml

from snowsim.io.files import written_whole


def write_page(path, folder, template, context, filters):
    """Write a page from a Jinja2 template of a folder, whole or not at all; an undefined name is an error."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(folder),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= filters
    page = environment.get_template(template).render(context)
    with written_whole(path) as aside:
        aside.write_text(page, encoding="utf-8")


def read_text(path):
    """A small text file."""
    return Path(path).read_text(encoding="utf-8")


def read_yaml(path):
    """A YAML file of plain values."""
    return yaml.safe_load(read_text(path))


def write_json(path, value):
    """Write plain values as JSON, whole or not at all, with the same bytes for the same value."""
    with written_whole(path) as aside:
        aside.write_text(json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False), encoding="utf-8")


def read_json(path):
    """A JSON file."""
    return json.loads(read_text(path))


def read_benchmarks(folder):
    """What Snakemake measured of every job, a row per job with its `rule`; no rows where nothing was measured.

    Files lie under ``folder/rule/...``; of a repeated measurement all lines count.
    """
    folder = Path(folder)
    tables = [
        pd.read_csv(path, sep="\t").assign(rule=path.relative_to(folder).parts[0])
        for path in sorted(folder.rglob("*.tsv"))
    ]
    if not tables:
        return pd.DataFrame({"rule": [], "s": [], "cpu_time": [], "max_rss": []})
    return pd.concat(tables, ignore_index=True)
