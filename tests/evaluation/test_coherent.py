"""The solver for layered media: laws, closed forms, and an independent calculation."""

import mpmath
import numpy as np
import pytest
from numpy.testing import assert_allclose

from evaluation.lib.coherent import fresnel, interface_delays_s, reflect, reflect_once
from snowsim.constants import SPEED_OF_LIGHT_M_S

SWEEP_HZ = np.linspace(2e9, 8e9, 31)


def random_stack(n_layers, rng, *, low=1.0, high=1.8):
    index = rng.uniform(low, high, n_layers + 2)
    return index, rng.uniform(0.001, 0.3, n_layers)


def lost(index, thickness_m):
    """Share of the energy that neither comes back nor through, and what comes through."""
    reflection, transmission = reflect(index, thickness_m, SWEEP_HZ)
    through = np.abs(transmission) ** 2
    widening = np.real(index[-1]) / np.real(index[0])
    return 1 - np.abs(reflection) ** 2 - widening * through, through


@pytest.mark.parametrize("n_layers", [0, 1, 2, 10, 100, 1000, 4000])
@pytest.mark.parametrize(("low", "high"), [(1.2, 1.4), (1.0, 3.0)])
def test_energy_is_conserved_also_where_next_to_nothing_comes_through(rng, n_layers, low, high):
    stack = random_stack(n_layers, rng, low=low, high=high)
    missing, through = lost(*stack)
    # Rounding of one layer, some 3 eps, adds up as a random walk: 4000 layers leave 5e-14.
    assert_allclose(missing, 0, atol=1e-12)
    assert (through.max() < 1e-6) == (high == 3.0 and n_layers >= 1000)


def test_energy_is_conserved_without_absorption_alone_and_stacks_are_solved_side_by_side(rng):
    index, thickness_m = random_stack(20, rng)
    absorbing = index.astype(complex)
    absorbing[1:-1] += 1e-3j
    missing, _ = lost(index, thickness_m)
    assert_allclose(missing, 0, atol=1e-13)
    missing, _ = lost(absorbing, thickness_m)
    assert missing.min() > 0.05
    indices, thicknesses_m = zip(*(random_stack(12, rng) for _ in range(3)), strict=True)
    reflection, transmission = reflect(np.stack(indices), np.stack(thicknesses_m), SWEEP_HZ)
    for i, stack in enumerate(zip(indices, thicknesses_m, strict=True)):
        alone = reflect(*stack, SWEEP_HZ)
        assert (reflection[i] == alone[0]).all()
        assert (transmission[i] == alone[1]).all()


def test_one_interface_is_fresnel_s_and_so_are_layers_of_one_medium(rng):
    reflection, transmission = reflect([1.0, 1.3], [], SWEEP_HZ)
    assert (reflection == fresnel(1.0, 1.3)).all()
    assert_allclose(fresnel(1.0, 1.3), -0.3 / 2.3, rtol=1e-15)
    assert_allclose(transmission, 2 / 2.3, rtol=1e-15)
    one_medium = [1.0] + 30 * [1.3]
    reflection, _ = reflect(one_medium, rng.uniform(0.01, 0.2, 29), SWEEP_HZ)
    assert_allclose(reflection, fresnel(1.0, 1.3), rtol=1e-15)


@pytest.mark.parametrize("order", [0, 1, 7])
@pytest.mark.parametrize("layer", [1.25, np.sqrt(1.7)])
def test_quarter_wave_layer_reflects_as_in_the_closed_form_and_not_at_all_where_matched(
    order, layer
):
    above, below = 1.0, 1.7
    quarter_m = SPEED_OF_LIGHT_M_S / 5e9 / layer / 4
    thickness_m = [(2 * order + 1) * quarter_m]
    reflection, transmission = reflect([above, layer, below], thickness_m, 5e9)
    # A phase of 15 pi / 2 is rounded by some 1e-15.
    expected = (above * below - layer**2) / (above * below + layer**2)
    assert_allclose(reflection, expected, atol=1e-14)
    assert_allclose(1.7 * np.abs(transmission) ** 2, 1 - expected**2, rtol=1e-13)
    half_wave, _ = reflect([above, layer, below], [2 * quarter_m], 5e9)
    assert_allclose(half_wave, fresnel(above, below), atol=1e-15)  # as if it were not there


def characteristic_matrix(index, thickness_m, frequency_hz):
    """Reflection and transmission from tangential fields, Abeles (1950), with 50 digits."""
    with mpmath.workdps(50):
        product = mpmath.eye(2)
        for n, d in zip(index[1:-1], thickness_m, strict=True):
            n = mpmath.mpmathify(complex(n))
            wavenumber = 2 * mpmath.pi * mpmath.mpf(frequency_hz) * n / mpmath.mpf(299792458)
            phase = wavenumber * mpmath.mpf(float(d))
            sine = mpmath.sin(phase)
            cosine = mpmath.cos(phase)
            product *= mpmath.matrix([[cosine, -1j * sine / n], [-1j * n * sine, cosine]])
        above = mpmath.mpmathify(complex(index[0]))
        below = mpmath.mpmathify(complex(index[-1]))
        electric = product[0, 0] + product[0, 1] * below
        magnetic = product[1, 0] + product[1, 1] * below
        denominator = above * electric + magnetic
        reflection = (above * electric - magnetic) / denominator
        return complex(reflection), complex(2 * above / denominator)


@pytest.mark.parametrize("n_layers", [1, 60, 300])
@pytest.mark.parametrize("loss", [0.0, 2e-4])
def test_both_amplitudes_equal_a_calculation_with_fifty_digits(rng, n_layers, loss):
    index, thickness_m = random_stack(n_layers, rng)
    index = index + 1j * loss
    sweep_hz = SWEEP_HZ[::6]
    both = np.transpose(reflect(index, thickness_m, sweep_hz))
    for found, frequency_hz in zip(both, sweep_hz, strict=True):
        expected = characteristic_matrix(index, thickness_m, frequency_hz)
        # Phases of up to 12,000 rad in all carry a rounding of 1e-12.
        assert_allclose(found, expected, atol=3e-12)


@pytest.mark.parametrize("losses", [True, False])
def test_what_single_scattering_leaves_out_is_of_third_order(rng, losses):
    shape = rng.standard_normal(22)
    thickness_m = rng.uniform(0.01, 0.3, 20)
    errors = []
    for step in (1e-3, 5e-4):
        index = 1.3 + step * shape
        exact, _ = reflect(index, thickness_m, SWEEP_HZ)
        once = reflect_once(index, thickness_m, SWEEP_HZ, losses=losses)
        errors.append(np.abs(once - exact).max())
    # Halving the contrast divides the error by 2^3; the next order is 5 %.
    assert_allclose(np.log2(errors[0] / errors[1]), 3, atol=0.1)
    assert errors[1] > 1e-11  # far from rounding


def test_delays_are_two_way_and_two_interfaces_lack_one_loss_and_one_multiple_of_born_s():
    stack = (np.array([1.0, 1.2, 1.6]), [0.1])
    r1 = fresnel(1.0, 1.2)
    r2 = fresnel(1.2, 1.6)
    turn = np.exp(4j * np.pi * SWEEP_HZ * 1.2 * 0.1 / SPEED_OF_LIGHT_M_S)
    born = reflect_once(*stack, SWEEP_HZ, losses=False)
    assert_allclose(born, r1 + r2 * turn, rtol=1e-13)
    with_losses = reflect_once(*stack, SWEEP_HZ)
    assert_allclose(with_losses, r1 + (1 - r1**2) * r2 * turn, rtol=1e-13)
    airy = (r1 + r2 * turn) / (1 + r1 * r2 * turn)
    exact, _ = reflect(*stack, SWEEP_HZ)
    assert_allclose(exact, airy, rtol=1e-13)
    delay_s = interface_delays_s(np.array([1.0, 1.2, 1.5]), np.array([0.3]))
    assert_allclose(delay_s, [0, 2 * 1.2 * 0.3 / SPEED_OF_LIGHT_M_S], rtol=1e-15)


@pytest.mark.parametrize(
    ("index", "thickness_m", "frequency_hz", "message"),
    [
        ([1.0], [], 5e9, "two media more"),
        ([1.0, 1.3, 1.4], [0.1, 0.1], 5e9, "two media more"),
        ([1.0, -1.3], [], 5e9, "real part positive"),
        ([1.0, 1.3 - 0.1j], [], 5e9, "imaginary part not negative"),
        ([1.0, np.nan], [], 5e9, "index must be finite"),
        ([1.0, 1.3, 1.4], [-0.1], 5e9, "thickness_m must be finite and not negative, got -0.1"),
        ([1.0, 1.3], [], np.inf, "frequency_hz must be finite"),
        ([1.0, 1.3 + 100j, 1.4], [10.0], 5e9, "numbers overflow"),
    ],
)
def test_impossible_stacks_are_refused(index, thickness_m, frequency_hz, message):
    with pytest.raises(ValueError, match=message):
        reflect(index, thickness_m, frequency_hz)
    if "overflow" not in message:
        with pytest.raises(ValueError, match=message):
            reflect_once(index, thickness_m, frequency_hz)
