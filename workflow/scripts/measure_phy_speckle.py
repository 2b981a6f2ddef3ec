"""Every speckle method: raw seconds, and how far its distribution function lies from that of the literal sum."""

from functools import partial

import numpy as np
import pandas as pd
from job import job

from lib.diagnostics.phy_alternatives import draw_moving_speckle
from lib.diagnostics.phy_errors import correlated_distance, cube_distance, moving_distance, quantile_distance
from lib.timing import device_name, time_rounds
from snowsim.io.files import write_table
from snowsim.phy import draw_speckle

N_LOOKS = (16, 100)
CORRELATION = (1, 0.16, 0.02)  # down range, of bins somewhat finer than a range response; others cost the same
MOVEMENTS_DB = (1.0, 3.0, 6.0, 10.0, 20.0)
DISTANCE = {"looks": lambda n_looks: 0.0, "gamma": lambda n_looks: 0.0, "cube": cube_distance,
            "quantile": quantile_distance}  # fmt: skip


def look_means(movement_db, n_looks):
    """Means that fall evenly in dB from the first look to the last."""
    return 10 ** (-np.linspace(0, movement_db, n_looks) / 10)


def measure(path_to_table, n_range_lines, n_range_bins, n_rounds, seed):
    rng = np.random.default_rng(seed)
    shape = (n_range_bins, n_range_lines)
    mean_power = np.ones(shape, dtype=np.float32)
    works = {("floor", "float32 normal"): partial(rng.standard_normal, shape, dtype=np.float32)}
    about = {}
    for n_looks in N_LOOKS:
        for method, distance in DISTANCE.items():
            key = (f"M = {n_looks}", method)
            works[key] = partial(draw_speckle, mean_power, n_looks, method=method, rng=rng)
            about[key] = {"distance": distance(n_looks), "n_looks": n_looks}
        key = (f"M = {n_looks}", "quantile, correlated")
        works[key] = partial(draw_speckle, mean_power, n_looks, method="quantile", correlation=CORRELATION, rng=rng)
        about[key] = {"distance": correlated_distance(n_looks), "n_looks": n_looks}
        for movement_db in MOVEMENTS_DB:
            means = look_means(movement_db, n_looks)
            key = (f"M = {n_looks}, {movement_db:g} dB", "gamma, moving")
            about[key] = {"distance": moving_distance(means), "n_looks": n_looks, "movement_db": movement_db}
    # The time does not depend on how far the mean moves.
    n_looks, movement_db = min(N_LOOKS), 6.0
    means = look_means(movement_db, n_looks).astype(np.float32)[:, None, None]
    moving = np.broadcast_to(means, (n_looks, *shape))
    setting = f"M = {n_looks}, {movement_db:g} dB"
    works[setting, "gamma, moving"] = partial(draw_moving_speckle, moving, method="gamma", rng=rng)
    works[setting, "looks, moving"] = partial(draw_moving_speckle, moving, method="looks", rng=rng)
    about[setting, "looks, moving"] = {"distance": 0.0, "n_looks": n_looks, "movement_db": movement_db}

    runs = time_rounds(works, n_rounds)
    runs += [(key, np.nan, np.nan) for key in about if key not in works]
    rows = [
        {
            "setting": key[0],
            "method": key[1],
            "repeat": repeat,
            "seconds": seconds,
            "n_pixels": mean_power.size,
            "device": device_name(),
        }
        | {"distance": np.nan, "n_looks": np.nan, "movement_db": np.nan}
        | about.get(key, {})
        for key, repeat, seconds in runs
    ]
    write_table(path_to_table, pd.DataFrame(rows))


if __name__ == "__main__":
    with job(snakemake):
        measure(*snakemake.output, **snakemake.params)
