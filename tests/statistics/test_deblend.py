import numpy as np
import pytest
from flights import frames_of
from numpy.testing import assert_allclose
from planted import waveform

from snowsim.statistics import estimate, merge, summarise
from snowsim.statistics.deblend import Groups, deblend, prepare_line, waveform_columns
from snowsim.statistics.paper import measure_groups
from snowsim.statistics.summaries import FIRST_ROW


def solution(groups):
    """Joint solution, started from decay rates read off averaged lines: values by name, powers."""
    decay, _ = measure_groups(groups)
    variables, powers = deblend(groups, decay)
    return {name: values for name, (_, values) in variables.items()}, powers


def crowded(rng, planted, n_groups=60):
    """Averaged lines with a thin slab of 9 bins, less than a 1/e width."""
    moved = np.arange(5) * rng.standard_normal((n_groups, 5))
    position = np.tile([0.2, 30, 39, 60, 100], (n_groups, 1)) + moved
    n_rows = 180 - FIRST_ROW
    lines = [planted.power(row[:, None] - FIRST_ROW, n_rows) for row in position]
    power = np.concatenate(lines, axis=1).T
    power = rng.gamma(100, power / 100)
    position = position[..., None]
    spread = np.zeros(position.shape)
    present = np.ones((n_groups, 5), dtype=bool)
    return Groups(power, position, spread, present, planted.noise_power)


def test_slopes_are_those_of_the_waveform(planted, rng):
    groups = crowded(rng, planted, 1)
    line = prepare_line(groups, 0)
    line.spread = np.linspace(0, 4, 5)[:, None]
    log_decay = np.log(planted.decay_rate)
    log_variance = np.log(planted.variance_bins2)
    shape = np.column_stack([log_decay, log_variance, np.linspace(-1, 1, 5)])
    slopes = waveform_columns(shape, line)
    step = 1e-5
    for i in range(3):
        change = np.zeros((5, 3))
        change[:, i] = step
        up = waveform_columns(shape + change, line)[0]
        down = waveform_columns(shape - change, line)[0]
        numeric = (up - down) / (2 * step)
        # Central differences of 1e-5: rounding of 1e-16 / 1e-5 and a third derivative of about 10
        # times 1e-10 / 6.
        assert_allclose(numeric, slopes[i + 1], atol=1e-9, rtol=1e-6)


def test_layers_closer_than_their_width_are_distinguished(planted, rng):
    groups = crowded(rng, planted)
    fitted, powers = solution(groups)
    # Shapes are alike by a fifth, and tails of layers so crowded do not tell them apart: they share
    # one. Powers, known to 1 %, take up what it leaves.
    assert_allclose(fitted["decay_rate"], planted.decay_rate, rtol=0.25)
    assert_allclose(powers.mean(axis=0), planted.peak_power, rtol=0.07)


def test_movement_within_a_group_is_no_variance(planted):
    # Noise-free mean of 20 lines whose layer moves by two bins: the Gaussian widens by 4 bins^2,
    # the fit does not.
    offsets = np.linspace(-1, 1, 20)
    offsets *= 2 / offsets.std()
    n_rows = 120 - FIRST_ROW
    base = np.array([[0.0], [44]])
    lines = [planted.power(base + offset - FIRST_ROW, n_rows)[:, 0] for offset in offsets]
    power = np.tile(np.mean(lines, axis=0), (8, 1))
    parts = np.sort(offsets).reshape(4, 5)
    position = np.tile(base + parts.mean(axis=1), (8, 1, 1))
    spread = np.tile(parts.var(axis=1), (8, 2, 1))
    groups = Groups(power, position, spread, np.ones((8, 2), dtype=bool), planted.noise_power)
    fitted, powers = solution(groups)
    # Positions are even within each part, not Gaussian: a fourth cumulant of -1.2 x 0.25^2 bins^4
    # beside 12.5^2.
    assert_allclose(fitted["variance_bins2"], 12.5, rtol=2e-3)
    assert_allclose(fitted["decay_rate"], planted.decay_rate[:2], rtol=1e-3)
    assert_allclose(powers, np.tile(planted.peak_power[:2], (8, 1)), rtol=1e-3)


@pytest.mark.parametrize("seed", [0, 1])
def test_crusts_that_nobody_picked_hardly_slow_the_decay(seed):
    """Slabs of 12 to 22 bins with 1.2 crusts each, of a median 6 % of the layer's power, patchy."""
    rng = np.random.default_rng(seed)
    slab = rng.uniform(12, 22, 11)
    pick = np.append(0, np.cumsum(slab)) + rng.uniform(-1, 1, (120, 1))
    layer = np.repeat(np.arange(11), rng.poisson(1.2, 11))
    crust = pick[:, layer] + slab[layer] * rng.uniform(0, 1, layer.size)
    of_crust = 0.9 * rng.standard_normal(layer.size)
    share = 0.06 * np.exp(of_crust + 0.6 * rng.standard_normal((120, layer.size)))
    lag = np.arange(-300, 300, 0.01)
    rows = np.arange(FIRST_ROW, 280)
    one = waveform(lag, 0.6, 0.1)
    one /= one.max()
    fall = np.exp(-0.1 * np.arange(12))
    peak = np.concatenate([fall + 0 * pick, share * fall[layer]], axis=1)
    position = np.concatenate([pick, crust], axis=1)
    power = np.full((120, rows.size), 1e-4)
    for row, height in zip(position.T, peak.T, strict=True):
        power += height[:, None] * np.interp(rows - row[:, None], lag, one)
    spread = np.zeros((120, 12, 1))
    seen = rng.gamma(100, power / 100)
    fitted, _ = solution(Groups(seen, pick[..., None], spread, pick > -9, 1e-4))
    # Without echoes between picks, and with less weight on residuals of either sign, it is 0.086
    # and 0.090.
    assert_allclose(fitted["decay_rate"][-1], 0.1, rtol=0.08)


def test_a_surface_far_wider_than_its_pick_is_no_solution():
    # One flight of the study of flights: fits from a wide start end at a surface of variance 200,
    # whose own peak counts as unpicked.
    firn = {"surface_density_kg_m3": 359.7, "horizon_jump_kg_m3": 162.1, "crusts_per_year": 1.662}
    firn |= {"layering_sd_kg_m3": 55.32, "fade_depth_m": 2.563, "crust_jump_kg_m3": 40.44}
    firn |= {"horizon_year_sd": 0.432}
    radar = {"bandwidth_hz": 5.861e9, "surface_to_noise_db": 24.49, "roughness_m": 0.0266}
    radar |= {"surface_slope": 0.01909, "horizon_slope": 0.02585, "line_gain_sd_db": 0.5538}
    radar |= {"sidelobe_db": -33.98, "band_noise_db": -3.862}
    climate = {"accumulation_factor": 1.126, "anomaly_sd": 0.1818, "undulation_sd": 0.08852}
    climate |= {"drift_sd": 0.08467, "relief_sd": 0.0567, "open_year": 0.7883}
    frames = frames_of({"climate": climate, "firn": firn, "radar": radar}, 2, 256, seed=2004)
    statistics = estimate(merge(summarise(*frame) for frame in frames))
    # In the flight itself .79; the surface is set to power 1.
    assert_allclose(statistics["variance_bins2"][0], 0.79, rtol=0.2)
    assert_allclose(statistics["peak_power"][0], 1, rtol=0.2)
