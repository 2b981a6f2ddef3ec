import numpy as np
from flights import BARE, climate_of, column_at
from numpy.testing import assert_allclose
from refusals import refusal
from scipy.ndimage import convolve1d

from reference import draw_complex_segment, draw_frame
from reference.column import reflectivity, surface_reflectivity
from reference.echo import draw_echo, draw_layering, draw_stretch
from reference.radar import range_response
from snowsim.alignment import along_track_m, bin_size_s, layer_bins_of
from snowsim.constants import SPEED_OF_LIGHT_M_S
from snowsim.echogram import check_echogram, check_layers
from snowsim.snowpack import firn


def echo_of(reference, surface_row, n_range_bins, rng):
    """Layers of 60 km along the line under these settings, and their echo."""
    climate = climate_of(reference)
    column = column_at(climate, 60, surface_row.size, n_range_bins - 50, rng=rng)
    echo = draw_echo(
        column, surface_row, n_range_bins, climate.settings.firn, climate.settings.radar, rng=rng
    )
    return column.layer_bins(surface_row), echo


def test_thickness_of_a_year_is_its_accumulation_and_density(rng):
    still = dict.fromkeys(("anomaly_sd", "undulation_sd", "drift_sd", "relief_sd"), 0.0)
    climate = climate_of({"climate": still | {"open_year": 1.0}})
    column = column_at(climate, 200, 10, 300, rng=rng)
    slab_bins = np.diff(column.layer_bins(np.zeros(10)), axis=0)[:5, 5]
    place = column.place
    surface_kg_m3 = climate.settings.firn.surface_density_kg_m3
    profile = (place.accumulation_m, place.temperature_k, surface_kg_m3)
    years = np.arange(5) + 0.5
    density = firn.density_herron_langway80(years * profile[0], *profile)
    slab_m = profile[0] * 1000 / density
    # Density at the middle of a year instead of its profile: second order in 3 % a year.
    slab_s = 2 * slab_m * firn.refractive_index_kovacs95(density) / SPEED_OF_LIGHT_M_S
    assert_allclose(slab_bins, slab_s / climate.settings.radar.bin_size_s, rtol=1e-3)
    # The table of depth is that of the same slabs; linear between 400 nodes.
    base_bins = np.cumsum(slab_bins)
    base_m = np.interp(base_bins, column.table_bins, column.table_depth_m)
    assert_allclose(base_m, np.cumsum(slab_m), rtol=2e-3)


def test_air_holds_noise_alone_surface_is_the_strongest_and_horizons_lie_5_to_20_db_below(rng):
    layer_bins, echo = echo_of(BARE, 50 + rng.uniform(-2, 2, 40), 450, rng)
    mean_db = 10 * np.log10(echo.mean())
    on_layers = mean_db[np.rint(layer_bins[:6]).astype(int), np.arange(40)].mean(axis=1)
    below_db = on_layers[0] - on_layers[1:]
    assert below_db.min() > 5
    assert below_db[:3].max() < 20
    # The transform of the buried echoes, some 0.01 strong, rounds to 1e-7 of them: 1e-9, noise
    # being 1e-6.
    assert_allclose(echo.mean()[:35], echo.noise_power, rtol=5e-3)


def test_layers_lie_where_the_mean_echo_peaks(rng):
    short_tails = {"surface_slope": 0.005, "horizon_slope": 0.005, "diffuse_share": 0.0}
    radar = BARE["radar"] | short_tails | {"n_sub_bins": 16}
    climate = climate_of(BARE | {"radar": radar})
    stretch = draw_stretch(climate, climate.settings, "flight", 60, 256, 50, 450, rng=rng)
    echo = stretch.echo
    received = convolve1d(echo.sub_bin_power, range_response(echo.radar) ** 2, axis=1)
    bins = stretch.layer_bins()[:6]  # the surface and the youngest
    first = echo.margin + np.rint(16 * bins).astype(int) - 16
    near = received[np.arange(256)[:, None], first[..., None] + np.arange(33)]
    peak_bins = (first + near.argmax(axis=-1) - echo.margin) / 16
    # Peaks are known to half a sub-bin, .03 bins; a shift of a fifth of a bin would be seen.
    assert_allclose(peak_bins, bins, rtol=0, atol=0.1)


def test_missing_lines_are_noise_and_positive_saturated_ones_noisy_and_clipped(rng):
    missing, saturated = (
        echo_of({"radar": BARE["radar"] | {rate: 1.0}}, np.full(20, 50.0), 250, rng)[1]
        for rate in ("missing_rate", "saturated_rate")
    )
    assert missing.without_echo.all()
    assert_allclose(missing.mean(), missing.noise_power, rtol=1e-5)
    assert (missing.draw(1, rng=rng) > 0).all()
    mean = saturated.mean()
    # The transform rounds to 1e-7 of an echo of 0.01; this noise is 1e-5.
    assert_allclose(mean[:30], mean[0, 0], rtol=5e-4)
    assert mean.max() < 0.32 + mean[0, 0]


def test_a_frame_follows_the_data_model_and_its_surface_is_its_first_layer(climate, rng):
    settings = climate.settings
    echogram, layers = draw_frame(3, 20, 192, climate=climate, settings=settings, rng=rng)
    check_echogram(echogram)
    check_layers(layers)
    assert echogram["Data"].dtype == np.float32
    assert np.isfinite(echogram["Data"]).all()
    for dataset in (echogram, layers):
        assert dataset.attrs["synthetic"] == "synthetic reference flight, not observed data"
        assert dataset.attrs["n_looks"] == 5
    assert_allclose(bin_size_s(echogram), 2.886e-10, rtol=1e-9)
    assert_allclose(np.diff(along_track_m(echogram)), 5.2, rtol=1e-4)
    assert_allclose(layers["twtt"][0], echogram["Surface"], atol=1e-3 * 2.886e-10)
    assert_allclose(layer_bins_of(layers, echogram)[0], settings.radar.surface_bin, atol=5)


def test_frames_that_do_not_fit_on_the_line_are_refused(climate, rng):
    with refusal("kilometres of 900 frames"):
        draw_frame(0, 900, 1024, climate=climate, settings=climate.settings, rng=rng)


def test_segment_is_5_km_of_complex_looks_that_are_independent_and_fifteen_layers(climate, rng):
    segment = draw_complex_segment(climate=climate, settings=climate.settings, rng=rng)
    assert segment.attrs["synthetic"].startswith("synthetic")
    assert_allclose(segment.attrs["line_spacing_m"] * segment.sizes["slow_time"], 5000, rtol=1e-3)
    assert segment.sizes["layer"] > 15
    assert np.isfinite(segment["layer_twtt"]).all()
    echo = (segment["Real"] + 1j * segment["Imaginary"]).values
    # The mean product of neighbours scatters by 1 / sqrt(n) of the power; one row counts at least.
    neighbours = np.mean(echo[:, 1:] * echo[:, :-1].conj())
    assert abs(neighbours) < 4 / np.sqrt(echo.shape[1]) * np.mean(np.abs(echo) ** 2)


def test_layering_has_the_deviation_and_length_of_the_logs_from_the_first_sample_on(rng):
    layering = draw_layering(4000, 200, 0.005, 50, 0.0225, rng=rng)
    # Samples within two lengths are alike: n_eff = n tanh(spacing / length) = 1.8e5 of 8e5; allow
    # four standard errors.
    assert_allclose(layering.std(), 50, rtol=4 / np.sqrt(2 * 1.7e5))
    products = layering[:, :-9] * layering[:, 9:]  # 9 samples, two lengths
    correlation = products.mean() / layering.var()
    assert_allclose(correlation, np.exp(-2), atol=4 / np.sqrt(1.7e5))
    assert_allclose(layering[:, :3].std(axis=0), 50, rtol=4 / np.sqrt(2 * 4000))


def test_a_small_step_and_a_surface_reflect_as_fresnel():
    above, below = firn.refractive_index_kovacs95([400 - 5, 400 + 5])
    fresnel = ((below - above) / (below + above)) ** 2
    assert_allclose(reflectivity(10, 400), fresnel, rtol=1e-12)
    of_air_on_snow = ((1.2873 - 1) / (1.2873 + 1)) ** 2
    assert_allclose(surface_reflectivity(340), of_air_on_snow, rtol=1e-4)
