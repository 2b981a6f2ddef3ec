"""What the powers of a scene tell a generator: how bright its layers are."""

import numpy as np

from snowsim.echogram import DB_BELOW_NOISE_FLOOR, to_db
from snowsim.labels import dress


def expected_brightness(scene, statistics):
    """Brightness of a scene's layers, (layer, range_line), NaN where absent.

    As `snowsim.cgan.render` takes it: of the mean power ``noise + sum_j p_j exp(-a_j (x - x_j))``
    in a layer's bin x, from all layers and backgrounds j down to it: peak powers and decay rates of
    eq. (1), the scene's own where it has echoes, else the flight's.
    """
    echoes = scene.echoes or dress(scene.layer_bins, statistics)
    total = np.full(scene.layer_bins.shape, echoes.noise_power)
    for row, power, decay in zip(echoes.bins, echoes.power, echoes.decay_rate, strict=True):
        lag = scene.layer_bins - row
        reached = power * np.exp(-decay * np.maximum(lag, 0))
        total += np.where((lag > -0.5) & (power > 0), reached, 0)
    present = np.isfinite(scene.layer_bins)
    above_floor_db = to_db(total / echoes.noise_power) + DB_BELOW_NOISE_FLOOR
    level = np.where(present, above_floor_db, np.nan)
    uppermost = present.any(axis=1).argmax()
    return level / np.nanmean(level[uppermost])
