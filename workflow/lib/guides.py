"""What PHY tells a generator of label sets: how bright their layers are, or its renders, in parts to be corrected."""

import numpy as np

from snowsim.cgan import guide_of
from snowsim.echogram import DB_BELOW_NOISE_FLOOR, to_db
from snowsim.phy import mean_field, plan, render_plan, scene_parameters
from snowsim.seeding import random_stream


class Guides:
    """A sequence of guides of label sets, each made when asked for: uncorrected they are PHY's renders to the byte.

    `phy` are options of `snowsim.phy.render.render_scene`.
    """

    def __init__(self, label_sets, statistics, phy, *, seed):
        self.label_sets, self.statistics, self.phy, self.seed = (
            label_sets,
            statistics,
            dict(phy),
            seed,
        )

    def __len__(self):
        return len(self.label_sets)

    def __getitem__(self, item):
        return self.of(self.label_sets[item])

    def of(self, scene):
        """The guide of a scene."""
        rng = random_stream(self.seed, "render_phy", scene.name)
        of_render = {
            key: self.phy[key]
            for key in ("tolerance_db", "speckle", "normalise", "align")
            if key in self.phy
        }
        drawn = {key: value for key, value in self.phy.items() if key not in of_render}
        layer_bins, parameters = scene_parameters(scene, self.statistics, **drawn, rng=rng)
        planned = plan(layer_bins, parameters, scene.n_range_bins, **of_render)
        mean = mean_field(planned, rng=rng)
        return guide_of(scene, mean, render_plan(planned, rng=rng, mean=mean.copy()))


def expected_brightness(scene, statistics):
    """Brightness of a scene's layers, (layer, range_line), NaN where absent, as `snowsim.cgan.render` takes it.

    Of the mean power ``noise + sum_j p_j exp(-a_j (x - x_j))`` in a layer's bin x, from all layers
    and backgrounds j down to it: peak powers and decay rates of eq. (1), the scene's own where it
    has them, else the flight's.
    """
    rows, flight = scene_parameters(scene, statistics, rng=None)
    powers = np.broadcast_to(np.reshape(flight["peak_power"], (len(rows), -1)), rows.shape)
    total = np.full(scene.layer_bins.shape, flight["noise_power"])
    for row, power, decay in zip(rows, powers, flight["decay_rate"], strict=True):
        lag = scene.layer_bins - row
        total += np.where(
            (lag > -0.5) & (power > 0), power * np.exp(-decay * np.maximum(lag, 0)), 0
        )
    level = np.where(
        np.isfinite(scene.layer_bins),
        to_db(total / flight["noise_power"]) + DB_BELOW_NOISE_FLOOR,
        np.nan,
    )
    return level / np.nanmean(level[np.isfinite(level).any(axis=1).argmax()])
