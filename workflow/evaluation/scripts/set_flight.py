"""Configuration of one flight of the study, as a file."""

from pathlib import Path

import yaml
from main_path import run

from snowsim.io.files import written_whole


def set_flight(settings_file, *, settings):
    with written_whole(settings_file) as aside:
        Path(aside).write_text(yaml.safe_dump(settings, sort_keys=False))


run(set_flight)
