"""Layers tracked in two passes over one place: which of one year are found in the other."""

import warnings
from functools import partial

from main_path import logger, run

from evaluation.lib import repeat_pass
from evaluation.lib.pictures import read_greenland
from snowsim.io.files import write_dataset, write_table
from snowsim.seeding import random_stream
from snowsim.tracking import Tracker


def tracked(tracker, means_db):
    """Rows (layer, column) that a tracker picks in a picture."""
    bin_s = tracker.card.bin_s
    with warnings.catch_warnings():
        # It notes that there are no positions.
        warnings.simplefilter("ignore", UserWarning)
        layers = tracker.pick(repeat_pass.as_echogram(means_db, bin_s))
    return repeat_pass.picked_rows(layers, bin_s, means_db.shape[1])


def match_repeat_pass(picks, table, *, folder, weights, n_draws, seed):
    # One file, with its digest.
    (path,) = weights
    tracker = Tracker.load(path)
    # By their dates: the earlier first.
    pictures = dict(sorted(read_greenland(folder).items()))
    earlier, later = map(partial(tracked, tracker), pictures.values())
    spacing = repeat_pass.median_spacing(earlier, later)
    comparison = repeat_pass.compare(earlier, later, spacing)
    rng = random_stream(seed, "match_repeat_pass")
    controls = repeat_pass.control(earlier, later, spacing, n_draws, rng=rng)
    found = repeat_pass.repeat_table(comparison, controls, spacing)
    logger.info("%s, %s\n%s", path, weights[path], found.T.to_string())
    write_table(table, found)
    write_dataset(picks, repeat_pass.picks_dataset(pictures, (earlier, later), comparison))


run(match_repeat_pass)
