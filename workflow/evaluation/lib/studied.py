"""Training sets of the studies: which scenes a tracker sees, and how often.

Each set is trained with several numbers of gradients, since sets need different ones.
"""

import re
from dataclasses import dataclass

from snowsim.tracker.sampling import PAPER_SCENES_PER_REAL

MORE_PER_REAL = 4.0  # added scenes of each kind for a real one


@dataclass(frozen=True)
class StudiedSet:
    """Scenes that a tracker is trained on.

    `real` are the scenes that an epoch shows once: `train`, the annotated scenes of the benchmark;
    `sample`, these and the annotated blocks of the sample flight, which statistics are fitted to;
    `completed`, the annotated scenes with the layers that the package's tracker finds beside their
    picks; or nothing. `added` are label sets rendered by methods, `added_per_real` scenes of each
    for a real one. `n_real` are the first of the train scenes, if not all. `labels` are the layers
    as `picked` or all of them, `complete`.
    """

    about: str
    real: str | None = "train"
    added: tuple = ()
    added_per_real: float = MORE_PER_REAL
    n_real: int | None = None
    labels: str = "picked"

    @property
    def data(self):
        """Options of `lib.tracker_training.compose`."""
        options = {"added_per_real": self.added_per_real, "labels": self.labels}
        return options if self.n_real is None else options | {"n_real": self.n_real}


SETS = {
    "rd": StudiedSet("RD"),
    "rd_sample": StudiedSet("RD + sample flight", "sample"),
    "rd_completed": StudiedSet("RD, picks completed", "completed"),
    "rd_full": StudiedSet("RD, every layer annotated", labels="complete"),
    "rd_pd_paper": StudiedSet("RD+PD, .64 a real scene", added=("phy",),
                              added_per_real=PAPER_SCENES_PER_REAL),
    "rd_pd": StudiedSet("RD+PD", added=("phy",)),
    "rd_sample_pd": StudiedSet("RD + sample flight + PD", "sample", ("phy",)),
    "rd_completed_pd": StudiedSet("RD, picks completed, + PD", "completed", ("phy",)),
    "rd_gd": StudiedSet("RD+GD", added=("cgan",)),
    "rd_gd_picked": StudiedSet("RD+GD, cGAN of picks as they are", added=("cgan_as_picked",)),
    "rd_pd_gd": StudiedSet("RD+PD+GD", added=("phy", "cgan")),
    "pd": StudiedSet("PD", None, ("phy",)),
    "gd": StudiedSet("GD", None, ("cgan",)),
    "pd_gd": StudiedSet("PD and GD", None, ("phy", "cgan"), added_per_real=1.0),
}  # fmt: skip
# The first scenes of RD alone, and with PHY's.
FIRST = re.compile(r"rd_first_(\d+)(_pd)?")
NAMES = "|".join([*SETS, FIRST.pattern.replace("(", "(?:")])


def studied_set(name):
    """The `StudiedSet` of a name: one of `SETS`, or the first scenes of RD, see `first_scenes`."""
    found = FIRST.fullmatch(name)
    if found is None:
        return SETS[name]
    n_real = int(found[1])
    added = ("phy",) if found[2] else ()
    # As many PHY scenes as 120 real ones would have: they cost no annotation.
    per_real = 120 * MORE_PER_REAL / n_real
    title = f"the first {n_real} scenes of RD" + (" + PD" if added else "")
    return StudiedSet(title, added=added, added_per_real=per_real, n_real=n_real)


def first_scenes(n_real, with_pd):
    """Name of the set with the first scenes of RD, alone or with PHY's."""
    return f"rd_first_{n_real}" + ("_pd" if with_pd else "")


def scored(budgets, split, table):
    """Paths of one `table`, scores or depths, on a split: a file a set and number of gradients."""
    return [f"results/studies/{name}/{n}/{split}_{table}.csv" for name, n in budgets]
