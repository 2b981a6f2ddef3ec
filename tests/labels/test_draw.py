import numpy as np
import pytest
from flights import climate_of
from numpy.testing import assert_allclose, assert_array_equal
from planted_labels import N_LINES, paper_model, planted

from snowsim.echogram import check_layer_bins, scene_height
from snowsim.front import REFERENCE
from snowsim.io.files import read_dataset
from snowsim.labels import draw, draw_scene, prepare
from snowsim.labels.process import correlation_factor, draw_series, leakage_matrix, line_variances
from snowsim.reference import checked_settings
from snowsim.reference import draw_scene as reference_scene
from snowsim.seeding import random_stream


def block_density(series):
    """One-sided periodogram by its definition, (wavenumber,), Nyquist not doubled."""
    n = series.shape[-1]
    turns = np.exp(-2j * np.pi * np.outer(np.arange(n // 2 + 1), np.arange(n)) / n)
    density = 2 * np.abs((series - series.mean(axis=-1, keepdims=True)) @ turns.T) ** 2 / n
    density[..., -1] /= 2
    return density


@pytest.fixture(scope="module")
def drawn():
    rng = np.random.default_rng(20120429)
    statistics = planted()
    model = paper_model(statistics, N_LINES)
    return statistics, [draw_scene(model, N_LINES, name=f"{i}", rng=rng) for i in range(1500)]


def test_layers_start_at_row_50_never_cross_and_number_6_to_41_rows(drawn):
    _, scenes = drawn
    for scene in scenes:
        check_layer_bins(scene.layer_bins)
        assert np.diff(scene.layer_bins, axis=0).min() >= 1 - 1e-9
        assert_array_equal(scene.layer_bins[0], 50)
        assert scene.n_range_bins == scene_height(scene.layer_bins)
    counts = np.bincount([len(scene.layer_bins) - 1 for scene in scenes], minlength=41)
    assert counts[:5].sum() == 0
    # 1500 / 36 = 42 a count, scatter 6.4: allow four and a half of those among 36.
    assert np.abs(counts[5:] - 1500 / 36).max() < 29


def test_draw_and_draw_scene_are_one_and_the_same_seed_gives_the_same_bytes():
    statistics = planted()
    one = draw(paper_model(statistics), N_LINES, rng=np.random.default_rng(1))
    model = paper_model(statistics)
    draw(model, N_LINES, rng=np.random.default_rng(2))  # what is kept from it changes nothing
    other = draw_scene(model, N_LINES, name="", rng=np.random.default_rng(1)).layer_bins
    assert one.tobytes() == other.tobytes()


def test_first_thickness_fixes_the_zone_and_covers_the_range_seen(drawn):
    statistics, scenes = drawn
    first = np.array([scene.notes["first_thickness_bins"] for scene in scenes])
    edges = statistics["zone_edge_bins"].values
    zone = np.array([scene.zone for scene in scenes])
    assert ((first >= edges[zone]) & (first < edges[zone + 1])).all()
    assert first.min() < 15.2
    assert first.max() > 39.8
    # Uniform over 25 bins: mean 27.5 to 7.2 / sqrt(1500) = 0.19; allow four.
    assert_allclose(first.mean(), 27.5, atol=0.75)
    thickness = [scene.layer_bins[1] - 50 for scene in scenes]
    # Notes have 20 binary digits, thickness is drawn to 2^-16 bins.
    assert_allclose(np.mean(thickness, axis=1), first, rtol=2**-20, atol=2**-17)


def test_moments_spectra_and_correlation_of_labels_are_those_of_the_flight(drawn):
    statistics, scenes = drawn
    psd = statistics["thickness_psd"].values
    n_slabs = psd.shape[1]
    anomaly = np.full((len(scenes), n_slabs), np.nan)
    slowest = np.full((len(scenes), n_slabs, 2), np.nan, dtype=complex)
    density = np.zeros((2, N_LINES // 2))
    for scene, of_scene, waves in zip(scenes, anomaly, slowest, strict=True):
        thickness = np.diff(scene.layer_bins, axis=0)[:n_slabs]
        n = len(thickness)
        of_slabs = psd[scene.zone, :n]
        of_scene[:n] = thickness.mean(axis=1) / thickness[0].mean() - (1 - 0.02 * np.arange(n))
        waves[:n] = np.fft.rfft(thickness)[:, 1:3] / np.sqrt(of_slabs[:, 1:3])
        density += [block_density(thickness).sum(axis=0)[1:], of_slabs.sum(axis=0)[1:]]
    # The deepest slab is that of 860 scenes: means to 0.1 / sqrt(860) = 0.0034; allow four.
    assert_allclose(np.nanmean(anomaly, axis=0), 0, atol=0.014)
    # Variances to 5 %, those of 19 correlated slabs together to some 2 %.
    assert_allclose(np.nanvar(anomaly[:, 1:], axis=0).mean(), 0.01, rtol=0.1)
    # 1500 scenes of several dozen correlated slabs: each wavenumber to 3 % or 0.15 dB at worst.
    assert np.abs(10 * np.log10(density[0] / density[1])).max() < 0.6
    for apart in range(1, 10):
        # Scenes count 1500 or more times; slow bands leak 3 % into one another when a block is cut.
        of_means = np.nanmean(anomaly[:, 1:-apart] * anomaly[:, 1 + apart :])
        assert_allclose(of_means / 0.01, 0.5**apart, atol=0.08)
        of_waves = np.nanmean((slowest[:, :-apart] * slowest[:, apart:].conj()).real)
        assert_allclose(of_waves / np.nanmean(np.abs(slowest) ** 2), 0.9**apart, atol=0.08)


def test_fewer_than_a_hundredth_of_thin_slabs_is_touched_and_all_are_counted(drawn):
    _, scenes = drawn
    n_touched, n_samples = (
        sum(scene.notes[name] for scene in scenes) for name in ("n_touched", "n_samples")
    )
    assert n_touched < 0.01 * n_samples
    rough = planted(scale=4e4)
    scene = draw_scene(paper_model(rough), N_LINES, name="rough", rng=np.random.default_rng(3))
    thickness = np.diff(scene.layer_bins, axis=0)
    assert 0 < scene.notes["n_touched"] < scene.notes["n_samples"]
    assert thickness.min() >= 1 - 1e-9
    assert scene.notes["thickness_mean_kept"] > scene.notes["thickness_mean_drawn"]


def test_slabs_below_the_flight_take_its_last_and_are_counted():
    statistics = planted(n_slabs=3)
    statistics["relative_thickness_variance"] = 0 * statistics["relative_thickness_variance"]
    statistics["thickness_psd"] = 0 * statistics["thickness_psd"]
    scene = draw_scene(paper_model(statistics, 64), 64, name="deep", rng=np.random.default_rng(4))
    thickness = np.diff(scene.layer_bins, axis=0)
    assert scene.notes["n_slabs_beyond"] == scene.notes["n_layers"] - 3
    # Thickness is drawn to 2^-16 bins.
    assert_allclose(thickness[2:] / thickness[0], 0.96, atol=2**-16)


def test_series_have_the_mean_block_spectrum_asked_for_and_do_not_end_where_they_began(rng):
    psd = planted()["thickness_psd"].values[0, 0]
    variances = line_variances(psd[None], 2 * N_LINES)
    series = draw_series(np.repeat(variances, 4000, axis=0), [], N_LINES, rng=rng)
    # 4000 periodograms: 1.6 % each; 128 of them, so four and a half of those.
    assert_allclose(block_density(series).mean(axis=0)[1:], psd[1:], rtol=0.072)
    assert_allclose(series.mean(axis=1), 0, atol=1e-12)
    # A periodic series would have the two equal; ends of an aperiodic one differ by about twice the
    # variance.
    across_the_end = (series[:, 0] - series[:, -1]).var()
    assert across_the_end > max(10 * np.diff(series, axis=1).var(), series.var())


def test_expected_leakage_is_what_a_cut_cosine_shows():
    matrix = leakage_matrix(32, 64)
    line = np.arange(32)
    for j in (1, 2, 7, 31):
        phase = 2 * np.pi * np.arange(16)[:, None] / 16
        cosines = np.sqrt(2) * np.cos(2 * np.pi * j * line / 64 + phase)
        assert_allclose(block_density(cosines).mean(axis=0)[1:], matrix[:, j - 1], atol=1e-9)


@pytest.mark.parametrize("n_range_lines", [2, 64, 300, 1024])
def test_a_scene_has_the_width_asked_for_and_its_share_of_the_variance(n_range_lines):
    rng = np.random.default_rng(5)
    model = paper_model(planted(), n_range_lines, n_layers=(5, 5))
    variance = []
    for _ in range(200):
        thickness = np.diff(draw(model, n_range_lines, rng=rng), axis=0)
        assert thickness.shape == (5, n_range_lines)
        variance.append(thickness.var(axis=1).mean())
    whole = planted()["thickness_psd"].values.sum(axis=2).mean() / N_LINES
    # Wider scenes also hold what undulates slower than a block, narrower ones less.
    assert (np.mean(variance) > 0.9 * whole) == (n_range_lines > N_LINES)


def test_factor_gives_back_a_valid_correlation_and_repairs_an_invalid_one():
    valid = 0.8 ** np.arange(6)
    factor = correlation_factor(valid, 6)
    row = np.arange(6)
    separation = np.abs(np.subtract.outer(row, row))
    assert_allclose(factor @ factor.T, valid[separation], atol=1e-12)
    repaired = correlation_factor(np.array([1, -0.9]), 5)
    assert_allclose(np.diag(repaired @ repaired.T), 1, rtol=1e-12)


def test_without_measured_correlation_slabs_undulate_apart():
    rng = np.random.default_rng(6)
    model = paper_model(planted(), N_LINES, n_layers=(5, 5), correlation="none")
    scenes = []
    for _ in range(300):
        thickness = np.diff(draw(model, N_LINES, rng=rng), axis=0)
        scenes.append(thickness - thickness.mean(axis=1, keepdims=True))
    correlation = np.corrcoef(np.concatenate(scenes, axis=1))
    # 300 scenes with some three independent undulations each: to 1 / 30; allow four.
    assert np.abs(correlation[np.triu_indices(5, 1)]).max() < 0.13


def test_bad_statistics_are_refused():
    statistics = planted()
    broken = statistics.copy(deep=True)
    broken["thickness_psd"].values[0, 0, 3] = np.nan
    with pytest.raises(ValueError, match="need thickness_psd, all finite"):
        paper_model(broken)
    with pytest.raises(ValueError, match="need n_blocks_by_layers"):
        draw(statistics, N_LINES, rng=np.random.default_rng(0))
    with pytest.raises(ValueError, match="need zone_edge_bins"):
        paper_model(statistics.drop_vars("zone_edge_bins"))
    with pytest.raises(ValueError, match="prepared for 256 range lines, got 128"):
        draw(paper_model(statistics), 128, rng=np.random.default_rng(0))
    with pytest.raises(
        ValueError, match="n_range_lines must be a whole number of at least 2, got 1"
    ):
        draw(statistics, 1, rng=np.random.default_rng(0))
    with pytest.raises(ValueError, match="correlation must be one of"):
        paper_model(statistics, correlation="some")


def test_layers_of_the_packaged_flight_change_along_track_as_annotated_ones():
    """The picker's errors are larger than that, so `finest_lines` leaves them out."""
    seed = 20120429
    settings = checked_settings({})
    climate = climate_of({}, seed)
    annotated = []
    for scene in range(20):
        rng = random_stream(seed, "reference_scenes", "validation", scene)
        truth = reference_scene(
            scene, "validation", climate=climate, settings=settings, n_looks=16, rng=rng
        )
        annotated.append(truth.layer_bins)
    model = prepare(read_dataset(REFERENCE), 256)
    drawn = [draw(model, 256, rng=np.random.default_rng(number)) for number in range(200)]
    upper, lower = slice(1, 9), slice(9, None)
    # Half of what the upper layers change over 8 lines is left out with the picker's errors.
    # Shorter undulations left in, 16 lines and longer ones, make the first of these ratios 1.4.
    # The median of 20 annotated scenes scatters by a fifth.
    for lag in (8, 16):
        assert (
            1 / 2.2 < median_change(drawn, upper, lag) / median_change(annotated, upper, lag) < 1.1
        )
        # Were neighbouring slabs independent, lower layers would gather the changes of all above:
        # 4 and 5 times as much. Six scenes have any, whose medians scatter by a third and by half.
        assert 1 / 2 < median_change(drawn, lower, lag) / median_change(annotated, lower, lag) < 2


def median_change(scenes, layers, lag):
    """Median over scenes of the mean square change of some of their layers over some lines."""
    changes = []
    for layer_bins in scenes:
        # Layers that are too faint to be labelled are NaN.
        held = layer_bins[np.isfinite(layer_bins).all(axis=1)][layers]
        if len(held):
            changes.append(held[:, lag:] - held[:, :-lag])
    return np.median([np.square(change).mean() for change in changes])
