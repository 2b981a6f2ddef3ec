"""Stamps of tables on the pages: which flight, benchmark scenes and label sets they are of.

They stand in the comment that opens a block, ``<!-- name: stamp -->``. A table whose stamp is not
that of the last run says so in its first line, the mark.
"""

import hashlib
import re
from dataclasses import dataclass

import numpy as np
import xarray as xr

from snowsim.io.scenes import SceneSet

N_DIGITS = 8
MARK = "*Of an earlier "
TABLE = "|---|"  # what every table of a block holds


@dataclass(frozen=True)
class Block:
    """What a page holds between the comments of a block."""

    name: str
    stamp: str  # empty if it has none
    text: str

    @property
    def is_marked(self):
        """Whether the page says that the table is of an earlier run."""
        return self.text.startswith(MARK)

    @property
    def has_table(self):
        """Whether the block has been filled."""
        return TABLE in self.text

    def marked(self, words):
        """The block with a mark in its first line."""
        return Block(self.name, self.stamp, f"{MARK}{words}.*\n\n{self.text}")

    def __str__(self):
        stamp = f": {self.stamp}" if self.stamp else ""
        return f"<!-- {self.name}{stamp} -->\n{self.text}<!-- /{self.name} -->"


def blocks_of(page):
    """Blocks of a page's text. ValueError if one is opened and not closed."""
    found = []
    for opened in re.finditer(r"<!-- (\w+)(?:: ([^>]*))? -->\n", page):
        name = opened[1]
        text, closed, _ = page[opened.end() :].partition(f"<!-- /{name} -->")
        if not closed:
            msg = f"expected <!-- /{name} --> after <!-- {name} -->, found none"
            raise ValueError(msg)
        found.append(Block(name, opened[2] or "", text))
    return found


def of_run(results):
    """Stamp of a run's tables."""
    flight = of_statistics(results / "statistics.nc")
    scenes = of_scenes(results.glob("benchmark/t*/*.nc"))  # train and test
    labels = of_files(results, "labels/*.nc")
    return f"flight {flight}, scenes {scenes}, labels {labels}"


def of_statistics(path):
    """Digest of a flight's statistics: the same for those of a run and as the package ships them.

    The package has them in float32.
    """
    digest = hashlib.sha256()
    with xr.open_dataset(path) as statistics:
        for name in sorted(statistics.data_vars):
            values = statistics[name].to_numpy()
            if values.dtype == np.float64:
                values = values.astype(np.float32)
            digest.update(name.encode())
            digest.update(values.tobytes())
    return digest.hexdigest()[:N_DIGITS]


def of_scenes(paths):
    """Digest of layers and of each scene's mean grey level, as a whole number.

    Single pixels differ by a level between types of processor.
    """
    digest = hashlib.sha256()
    with SceneSet(sorted(map(str, paths))) as scenes:
        for scene in scenes:
            digest.update(scene.layer_bins.tobytes())
            digest.update(np.uint8(round(scene.image.mean())).tobytes())
    return digest.hexdigest()[:N_DIGITS]


def of_files(results, pattern):
    """Digest of the files of a run that match a pattern."""
    digest = hashlib.sha256()
    for path in sorted(results.glob(pattern)):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:N_DIGITS]


def is_stale(results, table):
    """Whether a study's table is older than the flight's statistics or the label sets."""
    inputs = [*results.glob("statistics.nc"), *results.glob("labels/*.nc")]
    renewed = max((path.stat().st_mtime for path in inputs), default=0)
    return (results / table).stat().st_mtime < renewed
