"""How far simpler models are from the coherent one, on ensembles of stacks."""

import numpy as np

from snowsim.coherent.layers import interface_amplitudes, interface_delays_s, reflect, reflect_once
from snowsim.coherent.sweep import incoherent_profile, mean_profile

MODELS = ("transfer matrix", "Born", "single scattering", "convolution")


def model_works(index, thickness_m, frequency_hz, delay_s, bandwidth_hz):
    """What each of `MODELS` does for one ensemble, as callables that return its mean power, (delay,).

    Parameters
    ----------
    index : ndarray, (look, medium)
        Real refractive indices.
    thickness_m : ndarray, (look, layer)
    frequency_hz : ndarray, (frequency,)
        Of the sweep.
    delay_s : ndarray, (delay,)
        Of the profile, evenly spaced.
    bandwidth_hz : float

    Returns
    -------
    dict of callable
        ``transfer matrix``: all multiples, the reference. ``Born``: every interface once, undiminished by those above.
        ``single scattering``: with what these take away. ``convolution``: powers of the same echoes added without
        their phases, which is what eq. (1) of Yari et al. (2021), IEEE JSTARS 14, and the nature run do.
    """
    stack = (index, thickness_m)

    def convolution():
        power = interface_amplitudes(index) ** 2
        return incoherent_profile(power, interface_delays_s(*stack), delay_s, bandwidth_hz)

    return {
        "transfer matrix": lambda: mean_profile(reflect(*stack, frequency_hz)[0], frequency_hz, delay_s),
        "Born": lambda: mean_profile(reflect_once(*stack, frequency_hz, losses=False), frequency_hz, delay_s),
        "single scattering": lambda: mean_profile(reflect_once(*stack, frequency_hz), frequency_hz, delay_s),
        "convolution": convolution,
    }


def error_db(power, reference, noise_power=0.0):
    """Root mean square of the ratio of two mean powers, noise added to both [dB].

    Parameters
    ----------
    power, reference : array_like, any one shape
    noise_power : float
        What lies below it does not count.

    Raises
    ------
    ValueError
        If shapes differ, or a power with its noise is not positive and finite.
    """
    power, reference = (np.asarray(values, dtype=float) + noise_power for values in (power, reference))
    _check(power, reference)
    return float(np.sqrt(np.mean((10 * np.log10(power / reference)) ** 2)))


def bias_db(power, reference):
    """Ratio of the sums of two mean powers [dB]; ValueError as for `error_db`."""
    power, reference = np.asarray(power, dtype=float), np.asarray(reference, dtype=float)
    _check(power.sum(), reference.sum())
    return float(10 * np.log10(power.sum() / reference.sum()))


def _check(power, reference):
    good = power.shape == reference.shape and all((np.isfinite(p) & (p > 0)).all() for p in (power, reference))
    if not good:
        msg = f"expected two positive, finite powers of one shape, got shapes {power.shape} and {reference.shape}"
        raise ValueError(msg)
