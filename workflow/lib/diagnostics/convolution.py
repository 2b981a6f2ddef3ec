"""The convolution model beside simpler and full ones: mean range profiles of a sweep, and their errors."""

import numpy as np

from lib.diagnostics.coherent import interface_amplitudes, interface_delays_s, reflect, reflect_once

MODELS = ("transfer matrix", "Born", "single scattering", "convolution")


def sweep_frequencies_hz(start_hz, stop_hz, longest_delay_s):
    """Frequencies of a sweep, (frequency,), so close that no echo up to `longest_delay_s` is folded back."""
    if not (0 < start_hz < stop_hz and longest_delay_s > 0):
        msg = f"expected 0 < start < stop and a positive delay, got {start_hz:g}, {stop_hz:g} Hz, {longest_delay_s:g} s"
        raise ValueError(msg)
    n_steps = int(np.ceil((stop_hz - start_hz) * longest_delay_s)) + 1
    # Half a step inside both ends: a Hann window without zeros.
    return start_hz + (np.arange(n_steps) + 0.5) / n_steps * (stop_hz - start_hz)


def mean_profile(reflection, frequency_hz, delay_s):
    """Power of Hann-weighted range profiles at two-way travel times, averaged over looks, (delay,).

    ``p(t) = |sum_f w R exp(-2 pi i f t) / sum_f w|^2``, w the Hann window over evenly spaced frequencies and R the
    reflection (look, frequency): the beat signal of an FMCW radar, deramped and transformed. A mirror has power 1.
    """
    frequency_hz = np.asarray(frequency_hz, dtype=float)
    weight = np.sin(np.pi * (np.arange(frequency_hz.size) + 0.5) / frequency_hz.size) ** 2
    turn = np.exp(-2j * np.pi * np.multiply.outer(frequency_hz, np.asarray(delay_s, dtype=float)))
    profile = (np.asarray(reflection) * (weight / weight.sum())) @ turn
    return np.mean(np.abs(profile) ** 2, axis=0)


def incoherent_profile(power, at_s, delay_s, bandwidth_hz):
    """Sum of Hann range responses of points, by power and averaged over looks, (delay,): the convolution model.

    `power` and `at_s` (look, point) broadcast; `delay_s` is evenly spaced. The response is the Fourier transform of the
    Hann window, ``sinc(x) + (sinc(x - 1) + sinc(x + 1)) / 2`` with ``x = B t``; beyond ``|x| = 8``, below -60 dB, it is
    left out.
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


def model_works(index, thickness_m, frequency_hz, delay_s, bandwidth_hz):
    """What each of `MODELS` does for one ensemble of stacks, as callables that return its mean power, (delay,).

    ``transfer matrix``: all multiples, the reference. ``Born``: every interface once, undiminished by those above.
    ``single scattering``: with what these take away. ``convolution``: powers of the same echoes added without their
    phases, which is what eq. (1) of Yari et al. (2021), IEEE JSTARS 14, and the nature run do.
    """
    stack = (index, thickness_m, frequency_hz)
    sweep = (frequency_hz, delay_s)

    def convolution():
        power, at_s = interface_amplitudes(index) ** 2, interface_delays_s(index, thickness_m)
        return incoherent_profile(power, at_s, delay_s, bandwidth_hz)

    return {
        "transfer matrix": lambda: mean_profile(reflect(*stack)[0], *sweep),
        "Born": lambda: mean_profile(reflect_once(*stack, losses=False), *sweep),
        "single scattering": lambda: mean_profile(reflect_once(*stack), *sweep),
        "convolution": convolution,
    }


def error_db(power, reference, noise_power=0.0):
    """Root mean square of the ratio of two mean powers, noise added to both [dB]: what lies below it does not count.

    Powers of different shapes, or not positive and finite with their noise, are refused.
    """
    power, reference = (np.asarray(values, dtype=float) + noise_power for values in (power, reference))
    _check(power, reference)
    return float(np.sqrt(np.mean((10 * np.log10(power / reference)) ** 2)))


def bias_db(power, reference):
    """Ratio of the sums of two mean powers [dB]; refuses what `error_db` refuses."""
    power, reference = np.asarray(power, dtype=float), np.asarray(reference, dtype=float)
    _check(power.sum(), reference.sum())
    return float(10 * np.log10(power.sum() / reference.sum()))


def _check(power, reference):
    good = power.shape == reference.shape and all((np.isfinite(p) & (p > 0)).all() for p in (power, reference))
    if not good:
        msg = f"expected two positive, finite powers of one shape, got shapes {power.shape} and {reference.shape}"
        raise ValueError(msg)
