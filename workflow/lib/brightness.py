"""What PHY tells a generator of a scene: how bright its layers are."""

import numpy as np

from snowsim.echogram import DB_BELOW_NOISE_FLOOR, to_db
from snowsim.phy import scene_parameters


def expected_brightness(scene, statistics):
    """Brightness of a scene's layers, (layer, range_line), NaN where absent.

    As `snowsim.cgan.render` takes it: of the mean power ``noise + sum_j p_j exp(-a_j (x - x_j))``
    in a layer's bin x, from all layers and backgrounds j down to it: peak powers and decay rates of
    eq. (1), the scene's own where it has them, else the flight's.
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
