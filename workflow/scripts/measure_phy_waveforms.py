"""Mean power by every way there is: raw seconds and the largest error of each."""

from functools import partial

import numpy as np
import pandas as pd
from job import job

from lib.diagnostics.phy_alternatives import convolved_power, mean_power_by, naive_power, nearest_power, waveforms_of
from lib.diagnostics.phy_errors import largest_error_db, planted_scene
from lib.timing import device_name, time_rounds
from snowsim.io.files import write_table

TOLERANCES_DB = (0.5, 0.1, 0.05, 0.01, 1e-3, 1e-6)


def ways_of(layer_bins, parameters, n_range_bins):
    """Work by (setting, method)."""
    waveforms = waveforms_of(layer_bins, parameters, n_range_bins, "peak", "peak")
    by = partial(mean_power_by, waveforms=waveforms, noise_power=parameters["noise_power"])
    works = {
        ("1 sample per bin", "convolved"): partial(convolved_power, waveforms),
        ("4 samples per bin", "convolved"): partial(convolved_power, waveforms, samples_per_bin=4),
        ("as usually written", "naive closed form"): partial(naive_power, waveforms),
        ("every row", "closed form"): partial(by, "closed_form", tolerance_db=None),
        ("16 per bin", "nearest"): partial(nearest_power, waveforms),
    }
    for tolerance_db in TOLERANCES_DB:
        setting = f"{tolerance_db:g} dB"
        works[setting, "table"] = partial(by, "table", tolerance_db=tolerance_db)
        if tolerance_db in (0.5, 0.05, 1e-3):
            works[setting, "closed form in support"] = partial(by, "closed_form_in_support", tolerance_db=tolerance_db)
            for dtype in (np.float32, np.float64):
                name = f"recursive {np.dtype(dtype).name}"
                works[setting, name] = partial(by, "recursive", tolerance_db=tolerance_db, dtype=dtype)
    return works


def measure(path_to_table, n_layers, n_range_lines, n_range_bins, n_rounds, seed):
    rng = np.random.default_rng(seed)
    layer_bins, parameters = planted_scene(n_layers, n_range_lines, n_range_bins)
    works = ways_of(layer_bins, parameters, n_range_bins)
    exact = works["every row", "closed form"]()
    error_db = {key: largest_error_db(work(), exact, parameters["noise_power"]) for key, work in works.items()}
    works["floor", "float32 normal"] = partial(rng.standard_normal, exact.shape, dtype=np.float32)
    rows = [
        {
            "setting": key[0],
            "method": key[1],
            "repeat": repeat,
            "seconds": seconds,
            "n_pixels": exact.size,
            "error_db": error_db.get(key, np.nan),
            "device": device_name(),
        }
        for key, repeat, seconds in time_rounds(works, n_rounds)
    ]
    write_table(path_to_table, pd.DataFrame(rows))


if __name__ == "__main__":
    with job(snakemake):
        measure(*snakemake.output, **snakemake.params)
