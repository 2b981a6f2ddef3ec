"""Statistics of another climate and radar: what changes, by how much, and what stays."""

import dataclasses

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from refusals import refusal

from snowsim.front import REFERENCE
from snowsim.io import read_dataset
from snowsim.labels import draw, draw_scene, prepare
from snowsim.statistics import Ranges, Variation, changed, varied
from snowsim.statistics.variation import LOG_UNIFORM, OF_PULSE_LENGTH, OF_THICKNESS

# Statistics that some variation changes, and attributes.
CHANGES = {*OF_THICKNESS, *OF_PULSE_LENGTH, "noise_power", "background_power"}
CHANGES |= {"line_gain_spread_db", "speckle_correlation"}


@pytest.fixture(scope="module")
def flight():
    return read_dataset(REFERENCE)


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_thicker_snow_is_drawn_as_much_thicker_and_as_wavy(flight, factor):
    other = changed(flight, Variation(thickness=factor))
    for seed in range(8):
        layers = draw(flight, 256, rng=np.random.default_rng(seed))
        scaled = draw(other, 256, rng=np.random.default_rng(seed))
        slabs = np.diff(layers, axis=0)
        # Thin slabs are mirrored at one bin, which does not scale: compare those far from it.
        thick = (slabs > 4) & (factor * slabs > 4)
        # Thickness is a multiple of 2^-12 bins.
        assert_allclose(np.diff(scaled, axis=0)[thick], factor * slabs[thick], atol=2**-11)
        # The surface is the radar's.
        assert_array_equal(scaled[0], layers[0])


@pytest.mark.parametrize(
    ("variation", "factors"),
    [
        ({}, {}),
        # (4 variance, decay / 2) stretches exp(-x^2 / 2 variance) and exp(-decay x) alike.
        ({"pulse_length": 2.0}, {"variance_bins2": 4, "width_bins": 2, "decay_rate": 0.5}),
        ({"tail_length": 2.0}, {"decay_rate": 0.5}),
        ({"noise_db": 10.0}, {"noise_power": 10}),
        ({"background_db": -10.0}, {"background_power": 0.1}),
    ],
)
def test_a_variation_changes_what_it_names_and_nothing_else(flight, variation, factors):
    other = changed(flight, Variation(**variation))
    for name, values in flight.variables.items():
        # Rounded to float32, 6e-8.
        assert_allclose(other[name], factors.get(name, 1) * values, rtol=1e-6, err_msg=name)


def test_gain_looks_and_correlation_of_speckle_reach_the_echoes(flight):
    variation = Variation(line_gain_spread_db=0.9, n_looks=7.5, correlated=False)
    model = prepare(changed(flight, variation), 64)
    echoes = draw_scene(model, 64, name="", rng=np.random.default_rng(1)).echoes
    assert_allclose(echoes.line_gain_spread_db, 0.9, rtol=1e-6)
    assert echoes.n_looks == 7.5
    assert_array_equal(echoes.speckle_correlation, np.eye(9)[0])


def test_half_as_large_bins_hold_the_same_snow_and_pulse_in_twice_as_many(flight):
    finer = changed(flight, Variation(bin_size=0.5))
    twice = changed(flight, Variation(thickness=2.0, pulse_length=2.0))
    # The shipped statistics are of one estimator.
    for name in {*OF_THICKNESS, *OF_PULSE_LENGTH} & set(flight.variables):
        assert_array_equal(finer[name], twice[name], err_msg=name)
    correlation = flight["speckle_correlation"].values
    assert_array_equal(
        finer["speckle_correlation"][::2], correlation[: (len(correlation) + 1) // 2]
    )


def test_all_else_stays_and_what_was_drawn_is_told(flight, rng):
    other = varied(flight, rng=rng)
    for name in flight.variables.keys() - CHANGES:
        assert_array_equal(other[name], flight[name], err_msg=name)
        assert other[name].attrs == flight[name].attrs, name
    told = {key for key in other.attrs if key.startswith("varied_")}
    assert told == {f"varied_{field.name}" for field in dataclasses.fields(Variation)}
    assert other.attrs["n_looks"] == other.attrs["varied_n_looks"]


def test_draws_fill_their_ranges_and_no_more(rng):
    ranges = Ranges()
    drawn = [Variation.draw(ranges, rng=rng) for _ in range(2000)]
    for name, bounds in dataclasses.asdict(ranges).items():
        if name == "correlated_share":
            continue
        values = np.append(bounds, [getattr(each, name) for each in drawn])
        values = np.log(values) if name in LOG_UNIFORM else values
        share = (values[2:] - values[0]) / (values[1] - values[0])
        # The chance that 2000 draws leave out the first or the last hundredth: 2 * .99^2000.
        assert -1e-12 < share.min() < 0.01, name
        assert 0.99 < share.max() < 1 + 1e-12, name
        # Four standard errors of the mean of a uniform draw.
        assert abs(share.mean() - 0.5) < 4 / np.sqrt(12 * 2000), name


def test_statistics_without_thickness_are_refused_by_name(flight, rng):
    with refusal("statistic must be one of .* got 'zone_edge_bins'"):
        varied(flight.drop_vars("zone_edge_bins"), rng=rng)


def test_statistics_of_images_have_no_gain_to_change(flight, rng):
    lacking = flight.drop_vars(["line_gain_spread_db", "speckle_correlation"])
    other = varied(lacking, rng=rng)
    assert "line_gain_spread_db" not in other
