"""Training sets of the tracker, which mix real scenes with synthetic ones."""

import dataclasses
from functools import lru_cache

from snowsim.limits import check_count
from snowsim.patches import draw_index

PAPER_SCENES_PER_REAL = 1500 / 2360  # synthetic scenes of a set per real scene, Yari et al. (2021)
N_SCENES_HELD = 2500  # most real scenes kept in memory, each about .2 MB


class Completed:
    """Scenes with `complete_layer_bins` as their layers, where they have these."""

    def __init__(self, scenes):
        self._scenes = scenes

    def __len__(self):
        return len(self._scenes)

    def __getitem__(self, item):
        scene = self._scenes[item]
        if scene.complete_layer_bins is None:
            return scene
        return dataclasses.replace(
            scene, layer_bins=scene.complete_layer_bins, complete_layer_bins=None
        )


class TrainingSet:
    """Endless sequence of the scenes that a training draws, ``scenes[position]``.

    An epoch of `n_per_epoch` draws shows each real scene once, and from each added set
    `added_per_real` times as many, in random order. Scenes of an added set are drawn without
    replacement until all were shown, across epochs. A draw depends on seed and position alone, so
    that a resumed training draws the same scenes.

    Parameters
    ----------
    real : sequence of Scene
        Scenes are read when they are drawn. Real ones are then kept in memory, since they are drawn
        again in every epoch.
    added : sequence of sequence of Scene
        Synthetic sets; empty for training on real scenes alone.
    added_per_real : float
        Scenes of each added set per real scene. ValueError if this gives no scene in an epoch, or
        if a set is empty.
    seed : int
    """

    def __init__(
        self,
        real,
        added=(),
        *,
        added_per_real=PAPER_SCENES_PER_REAL,
        seed,
    ):
        self._sets = (real, *added)
        self._held = lru_cache(maxsize=N_SCENES_HELD)(real.__getitem__)
        self._n_added = round(len(real) * added_per_real)
        for scenes in self._sets:
            check_count("scenes of a set", len(scenes))
        if added:
            check_count("added scenes an epoch", self._n_added)
        self._seed = seed
        self.n_per_epoch = len(real) + len(added) * self._n_added

    def hold(self):
        """Read the real scenes into memory; called before the processes that share them start."""
        for number in range(min(len(self._sets[0]), N_SCENES_HELD)):
            self._held(number)

    def source(self, position):
        """Numbers (set, scene) of the scene at `position`; set 0 has the real scenes."""
        epoch = position // self.n_per_epoch
        slot = draw_index(self.n_per_epoch, position, self._seed, "training set", "order")
        n_real = len(self._sets[0])
        if slot < n_real:
            return 0, slot
        before, within = divmod(slot - n_real, self._n_added)
        number = before + 1
        draw = epoch * self._n_added + within
        n_scenes = len(self._sets[number])
        return number, draw_index(n_scenes, draw, self._seed, "training set", number)

    def __getitem__(self, position):
        number, scene = self.source(position)
        return self._held(scene) if number == 0 else self._sets[number][scene]


def copy_shown(position, n_per_epoch, n_copies, seed):
    """Draw of a `TrainingSet` and number of its copy that a training shows at `position`.

    Every epoch shows all copies of its draws in random order.
    """
    n_gradients = n_copies * n_per_epoch
    slot = draw_index(n_gradients, position, seed, "training set", "copies")
    copy, within = divmod(slot, n_per_epoch)
    epoch = position // n_gradients
    return epoch * n_per_epoch + within, copy
