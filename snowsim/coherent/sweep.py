"""What a frequency sweep makes of a reflection: range profiles, coherent or as sums of powers."""

import numpy as np


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
