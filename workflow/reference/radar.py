"""The radar: range response of the sweep, off-nadir tail, looks, and faults along the flight."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.signal import lfilter, upfirdn

from snowsim.constants import SPEED_OF_LIGHT_M_S
from snowsim.seeding import rounded

# Half-length of the tabulated range response in 1 / bandwidth; side lobes beyond are below -50 dB.
RESPONSE_WIDTH = 4
PEDESTAL_FALLS = 6  # 1/e delays over which sidelobes are computed, to 26 dB below their level
TAIL_END = 1e-4  # share of its peak below which the off-nadir tail is cut
SATURATION_NOISE = 10.0  # noise of an overloaded receiver, relative to that of a sound one
SATURATION_LEVEL = 0.3  # power at which it clips, relative to the echo of a mean surface


def hann_response(delay_s, bandwidth_hz):
    """Amplitude of an FMCW radar's response to a point, 1 at zero delay.

    A Hann window weights the beat signal, so the response is that window's Fourier transform,
    ``sinc(x) + (sinc(x - 1) + sinc(x + 1)) / 2`` with ``x = B delay`` and sinc(x) = sin(pi x) / (pi
    x): Harris (1978), Proc. IEEE 66, 51-83. Its nulls lie at x = +-2 and its equivalent width is
    1.5 / B: for 6 GHz 0.200 m between nulls and 0.075 m, of path there and back.
    """
    x = np.asarray(delay_s, dtype=float) * bandwidth_hz
    return np.sinc(x) + 0.5 * (np.sinc(x - 1) + np.sinc(x + 1))


def backscatter_geometric_optics(angle_rad, rms_slope, diffuse_share):
    """Backscatter of a gently rough interface by angle of incidence, relative to nadir.

    Geometric optics with Gaussian slopes, ``exp(-tan^2 / 2 s^2) / cos^4``, s the slope along one
    axis: Ulaby, Moore & Fung (1982), Microwave Remote Sensing II, section 12-5. To this a diffuse
    share is added, which follows the cosine of the angle.
    """
    angle_rad = np.asarray(angle_rad, dtype=float)
    cosine = np.cos(angle_rad)
    facets = np.exp(-(np.tan(angle_rad) ** 2) / (2 * rms_slope**2)) / cosine**4
    return (1 - diffuse_share) * facets + diffuse_share * cosine


def annulus_power(delay_s, height_m, rms_slope, diffuse_share, beamwidth_deg):
    """Power from the annulus seen at a delay [s] after the nadir point, relative to zero delay.

    The radar equation over a plane: range ``R = H + c t / 2``, ``cos theta = H / R``, area per
    delay ``2 pi R dR/dt``, spreading ``R^-4``, hence ``G(theta)^2 sigma0(theta) / R^3``. This is
    the flat-plane form of Brown (1977), IEEE Trans. Antennas Propag. 25, 67-74, before his
    convolution with pulse and heights. `height_m` is that of the antenna over the interface. One
    antenna's beam is Gaussian, `beamwidth_deg` wide between its 3 dB points. Refraction in the firn
    above a buried interface is neglected; over 20 m it moves the annuli by 1 %. Since it also turns
    rays towards the normal, the slope of a buried interface is the one seen from the air, n times
    its own.
    """
    range_m = height_m + SPEED_OF_LIGHT_M_S * np.asarray(delay_s, dtype=float) / 2
    angle = np.arccos(height_m / range_m)
    off_axis = angle / np.radians(beamwidth_deg)
    two_way_gain = np.exp(-4 * np.log(2) * off_axis**2) ** 2
    backscatter = backscatter_geometric_optics(angle, rms_slope, diffuse_share)
    return two_way_gain * backscatter * (height_m / range_m) ** 3


@dataclass(frozen=True)
class Waveform:
    """Mean echo of one interface on the sub-bin grid, before the range response.

    `power`, float32 (sub_bin,), sums to 1, since a rougher interface spreads its power and adds
    none. `lead` counts sub-bins from its first sample to the peak of the received waveform; `peak`
    is the height of that peak.
    """

    power: np.ndarray
    lead: float
    peak: float


@lru_cache(maxsize=32)
def range_response(radar):
    """Range response on the sub-bin grid, float32 (tap,), centred; its squares sum to 1."""
    reached_hz = radar.bandwidth_hz / radar.response_widening
    half = int(np.ceil(RESPONSE_WIDTH / reached_hz / radar.sub_bin_s))
    taps = hann_response(np.arange(-half, half + 1) * radar.sub_bin_s, reached_hz)
    return (taps / np.sqrt((taps**2).sum())).astype(np.float32)


@lru_cache(maxsize=256)
def interface_waveform(radar, rms_slope, roughness_m):
    """`Waveform` of an interface: the off-nadir tail of its annuli, spread by its roughness.

    `roughness_m` is the standard deviation of height; the refractive index of snow is taken as 1.3.
    """
    finer = 8
    n_samples = radar.n_range_bins * radar.n_sub_bins  # the diffuse share reaches beyond any window
    delay_s = (np.arange(n_samples * finer) + 0.5) * radar.sub_bin_s / finer
    tail = annulus_power(
        delay_s, radar.height_m, rms_slope, radar.diffuse_share, radar.beamwidth_deg
    )
    tail = tail.reshape(-1, finer).mean(axis=1)
    is_faint = tail < TAIL_END * tail[0]
    tail = tail[: int(np.argmax(is_faint)) or n_samples]
    spread = roughness_m * 1.3 * 2 / SPEED_OF_LIGHT_M_S / radar.sub_bin_s
    power = np.pad(tail, int(np.ceil(4 * spread)) + 1)
    if spread > 0:
        power = gaussian_filter1d(power, spread, mode="constant")
    power /= power.sum()
    received = np.convolve(power, range_response(radar).astype(float) ** 2, mode="same")
    top = int(np.argmax(received))
    left, middle, right = received[top - 1 : top + 2]
    lead = top + 0.5 * (left - right) / (left - 2 * middle + right)
    return Waveform(power.astype(np.float32), float(lead), float(middle))


def received_mean(sub_bin_power, radar, margin):
    """Mean detected power at range bins, (range_line, range_bin).

    `sub_bin_power`, (range_line, sub_bin), is the variance of scatterers. It has `margin` sub-bins,
    at least half the length of `range_response`, before the first range bin and after the last.
    """
    return _filtered(sub_bin_power, range_response(radar) ** 2, radar.n_sub_bins, margin)


def draw_look(amplitude, radar, margin, *, rng):
    """Draw the complex echo of one look at range bins, complex64 (range_line, range_bin).

    Scatterers are circular complex Gaussian and independent between looks, range lines and
    sub-bins; the range response correlates neighbouring bins. `amplitude`, float32 (range_line,
    sub_bin), is the square root of half their mean power. float32 rounds by 1e-7 of a quantity that
    is itself random.
    """
    parts = rng.standard_normal((2, *amplitude.shape), dtype=np.float32)
    parts *= amplitude
    response = range_response(radar)
    real, imaginary = (_filtered(part, response, radar.n_sub_bins, margin) for part in parts)
    return real + np.complex64(1j) * imaginary


def draw_detected(sub_bin_power, radar, margin, n_looks, *, rng):
    """Draw the mean power of `n_looks` looks, float32 (range_line, range_bin); see `draw_look`."""
    amplitude = np.sqrt(sub_bin_power / 2)
    total = np.float32(0)
    response = range_response(radar)
    for _ in range(2 * n_looks):  # real and imaginary parts
        part = rng.standard_normal(amplitude.shape, dtype=np.float32)
        part *= amplitude
        total = total + _filtered(part, response, radar.n_sub_bins, margin) ** 2
    return total / np.float32(n_looks)


def _filtered(field, taps, n_sub_bins, margin):
    """Convolution with centred, symmetric taps, kept at every range bin."""
    half = taps.size // 2
    early = -2 * half % n_sub_bins  # so that the first value kept is a multiple of n_sub_bins
    n_bins = (field.shape[1] - 2 * margin) // n_sub_bins
    first = margin - half - early
    last = margin + half + (n_bins - 1) * n_sub_bins
    inside = field[:, first : last + 1]
    start = (2 * half + early) // n_sub_bins
    return upfirdn(taps, inside, down=n_sub_bins, axis=1)[:, start : start + n_bins]


def sidelobes(radar):
    """Power of one echo's sidelobes on the sub-bin grid, float32 (tap,), centred on the echo.

    Imperfect deconvolution leaves a pedestal on both sides of every echo, which falls exponentially
    with delay; the main lobe, 2 / B to either side, has none. `sidelobe_db` is the pedestal's level
    at zero delay relative to the echo's peak.
    """
    half = int(np.ceil(PEDESTAL_FALLS * radar.sidelobe_fall_s / radar.sub_bin_s))
    delay_s = np.abs(np.arange(-half, half + 1)) * radar.sub_bin_s
    level = 10 ** (radar.sidelobe_db / 10) * np.exp(-delay_s / radar.sidelobe_fall_s)
    level[delay_s < 2 / radar.bandwidth_hz] = 0
    # The range response is applied after this. Its peak is 1 / its equivalent width, which for a
    # Hann window is 1.5 / B.
    return (level * radar.sub_bin_s * radar.bandwidth_hz / 1.5).astype(np.float32)


def draw_coherent_noise(n_sub_bins, radar, *, rng):
    """Draw the power of coherent noise, relative to thermal noise, float32 (sub_bin,).

    What is left after its removal are horizontal bands at fixed travel times, `band_spacing_s`
    apart on average, of Gaussian shape and exponentially distributed power of mean `band_noise_db`.
    """
    n_bands = rng.poisson(n_sub_bins * radar.sub_bin_s / radar.band_spacing_s)
    centre = rng.uniform(0, n_sub_bins, n_bands)[:, None]
    strength = 10 ** (radar.band_noise_db / 10) * rng.exponential(1, n_bands)
    away = (np.arange(n_sub_bins) - centre) * radar.sub_bin_s / radar.band_width_s
    bands = strength[:, None] * np.exp(-(away**2) / 2)
    return bands.sum(axis=0).astype(np.float32)


def quantised(power, step_db):
    """Power in whole steps of decibels, as products store it; a step of 0 changes nothing."""
    if step_db == 0:
        return power
    # In float64, and rounded: single logarithms and powers differ between processors.
    with np.errstate(divide="ignore"):
        steps = np.rint(np.log10(power, dtype=float) * (10 / step_db))
    return rounded(10 ** (steps * (step_db / 10)), 20).astype(np.float32)


def draw_roll_gain(n_lines, radar, *, rng):
    """Draw the power gain of roll fades, (range_line,): a two-state Markov chain, first level."""
    uniform = rng.random(n_lines)
    gain = np.ones(n_lines)
    rolled = False
    for line in range(n_lines):
        rolled = uniform[line] >= radar.roll_leave if rolled else uniform[line] < radar.roll_enter
        if rolled:
            gain[line] = radar.roll_gain
    return gain


def draw_receiver_gain(n_lines, radar, *, rng):
    """Draw the receiver's gain of power, (range_line,): jumps that last, and a spread by line."""
    is_jump = rng.random(n_lines) < radar.jump_rate
    jumps_db = np.where(is_jump, radar.jump_sd_db * rng.standard_normal(n_lines), 0)
    of_line_db = radar.line_gain_sd_db * rng.standard_normal(n_lines)
    return 10 ** ((np.cumsum(jumps_db) + of_line_db) / 10)


def draw_surface_row(n_lines, surface_bin, radar, *, rng):
    """Draw the row of the surface after elevation compensation, (range_line,).

    Compensation removes the aircraft's movement in whole range bins, as in the product, and leaves
    the fraction of a bin. The tracker that steers it adds a slow error.
    """
    bin_m = radar.bin_size_s * SPEED_OF_LIGHT_M_S / 2
    persistence = np.exp(-radar.line_spacing_m / 200)
    movement = rng.standard_normal(n_lines)
    movement[1:] *= np.sqrt(1 - persistence**2)
    movement = lfilter([1], [1, -persistence], movement)
    movement = gaussian_filter1d(movement, 5) * radar.jitter_m / bin_m
    width = 20
    margin = 5 * width
    error = gaussian_filter1d(rng.standard_normal(n_lines + 2 * margin), width)
    error = error[margin : margin + n_lines]
    error *= np.sqrt(2 * width * np.sqrt(np.pi))  # unit variance
    return surface_bin + movement - np.rint(movement) + radar.tracking_sd_bins * error
