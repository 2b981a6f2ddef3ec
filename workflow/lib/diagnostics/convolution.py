"""What a frequency sweep makes of a reflection: range profiles, coherent or as sums of powers.

How far simpler models are from the coherent one, on ensembles of stacks.
"""

import numpy as np

from lib.diagnostics.coherent import interface_amplitudes, interface_delays_s, reflect, reflect_once


def sweep_frequencies_hz(start_hz, stop_hz, longest_delay_s):
    """Frequencies of a sweep, close enough that no echo up to `longest_delay_s` is folded back, (frequency,).

    Raises
    ------
    ValueError
        Unless ``0 < start_hz < stop_hz`` and the delay is positive.
    """
    if not (0 < start_hz < stop_hz and longest_delay_s > 0):
        msg = f"expected 0 < start < stop and a positive delay, got {start_hz:g}, {stop_hz:g} Hz, {longest_delay_s:g} s"
        raise ValueError(msg)
    n_steps = int(np.ceil((stop_hz - start_hz) * longest_delay_s)) + 1
    # Half a step inside both ends: a Hann window without zeros.
    return start_hz + (np.arange(n_steps) + 0.5) / n_steps * (stop_hz - start_hz)


def mean_profile(reflection, frequency_hz, delay_s):
    """Power of Hann-weighted range profiles, averaged over looks, (delay,).

    Parameters
    ----------
    reflection : array_like of complex, (look, frequency)
    frequency_hz : array_like, (frequency,)
        Evenly spaced, see `sweep_frequencies_hz`.
    delay_s : array_like, (delay,)
        Two-way travel times wanted.

    Returns
    -------
    ndarray, (delay,)
        A mirror at a delay has power 1 there.

    Notes
    -----
    ``p(t) = |sum_f w R exp(-2 pi i f t) / sum_f w|^2``, w the Hann window over the sweep: the beat signal of an FMCW
    radar, deramped and transformed.
    """
    frequency_hz = np.asarray(frequency_hz, dtype=float)
    weight = np.sin(np.pi * (np.arange(frequency_hz.size) + 0.5) / frequency_hz.size) ** 2
    turn = np.exp(-2j * np.pi * np.multiply.outer(frequency_hz, np.asarray(delay_s, dtype=float)))
    profile = (np.asarray(reflection) * (weight / weight.sum())) @ turn
    return np.mean(np.abs(profile) ** 2, axis=0)


def incoherent_profile(power, at_s, delay_s, bandwidth_hz):
    """Sum of the powers of points' Hann range responses: the convolution model, (delay,), averaged over looks.

    Parameters
    ----------
    power, at_s : array_like, (look, point)
        Reflected power and two-way travel time of every point.
    delay_s : array_like, (delay,)
        Evenly spaced travel times wanted.
    bandwidth_hz : float

    Notes
    -----
    The response is the Fourier transform of the Hann window, ``sinc(x) + (sinc(x - 1) + sinc(x + 1)) / 2`` with
    ``x = B t``; beyond ``|x| = 8``, below -60 dB, it is left out.
    """
    power, at_s = np.broadcast_arrays(np.asarray(power, dtype=float), np.asarray(at_s, dtype=float))
    delay_s = np.asarray(delay_s, dtype=float)
    step_s = (delay_s[-1] - delay_s[0]) / (delay_s.size - 1)
    reach = int(np.ceil(8 / bandwidth_hz / step_s))
    nearest = np.rint((at_s.ravel() - delay_s[0]) / step_s).astype(int)
    rows = nearest[:, None] + np.arange(-reach, reach + 1)
    x = (delay_s[0] + rows * step_s - at_s.ravel()[:, None]) * bandwidth_hz
    response = (np.sinc(x) + 0.5 * (np.sinc(x - 1) + np.sinc(x + 1))) ** 2 * power.ravel()[:, None]
    inside = (rows >= 0) & (rows < delay_s.size)
    return np.bincount(rows[inside], response[inside], minlength=delay_s.size) / power.shape[0]


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
