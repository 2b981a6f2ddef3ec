"""Flight statistics from annotated frames: summarise each, merge in any order, estimate once."""

import warnings

import numpy as np

from snowsim.echogram import FAR_BINS, surface_away_bins
from snowsim.progress import shown
from snowsim.statistics.doubts import looks_like_amplitude
from snowsim.statistics.estimate import ESTIMATORS, estimate
from snowsim.statistics.speckle import doppler_spectra
from snowsim.statistics.summaries import merge, summarise
from snowsim.statistics.thickness import MINIMUM_BLOCKS
from snowsim.statistics.varied import Ranges, Variation, changed, varied

__all__ = ["ESTIMATORS", "Ranges", "Variation", "changed", "doppler_spectra", "estimate", "fit"]
__all__ += ["merge", "summarise", "varied", "warn_of_little"]


def fit(frames, *, estimator="deblended"):
    """Statistics of a flight.

    Frames are read one at a time, in any order; each leaves a summary of about 0.4 kB per range
    line. Warns of each statistic that stands on too little of a flight, and says on how much, and
    where layer 0 lies far from the echogram's `Surface`: its power then counts as the surface's.

    Parameters
    ----------
    frames : iterable of (xarray.Dataset, xarray.Dataset)
        Echogram and layers of each frame (Open Polar Radar convention), one bin size throughout.
    estimator : {"deblended", "paper"}
        `deblended` solves for overlapping layers and noise jointly; `paper` is Yari et al. (2021)
        as printed.

    Returns
    -------
    xarray.Dataset
        See `estimate`.

    Raises
    ------
    ValueError
        If there is no frame, bin sizes differ, a dataset breaks the convention or looks like
        amplitude in place of power, or `estimate` refuses the flight.

    Examples
    --------
    Two simulated frames:

    >>> from snowsim import Climate, simulate
    >>> snow = Climate(accumulation_m=0.4)
    >>> frames = (simulate(snow, "snow-2012", n_range_lines=512, rng=i) for i in range(2))
    >>> statistics = fit(frames, estimator="paper")
    >>> statistics["thickness_mean_bins"].dims
    ('zone', 'slab')
    >>> statistics.attrs["n_frames"]
    2
    >>> bool(statistics["peak_power"][0] > statistics["peak_power"][1])
    True
    """
    summaries = []
    away_bins = []
    for number, (echogram, layers) in enumerate(shown(frames, unit="frame")):
        where = f"frame {number}"
        summaries.append(summarise(echogram, layers, where=where))
        if looks_like_amplitude(echogram, layers):
            msg = f"{where}: Data: expected linear power, found amplitude, by the skewness of the "
            msg += "noise above the surface: square it"
            raise ValueError(msg)
        away_bins.append(surface_away_bins(echogram, layers))
    summary = merge(summaries)
    far_bins = [bins for bins in away_bins if bins > FAR_BINS]
    if far_bins:
        msg = f"layer 0 lies {np.median(far_bins):.0f} range bins from the echogram's Surface in "
        msg += f"{len(far_bins)} of {len(away_bins)} frames: is it the snow surface?"
        warnings.warn(msg, UserWarning, stacklevel=2)
    statistics = estimate(summary, estimator=estimator)
    warn_of_little(statistics)
    return statistics


def warn_of_little(statistics):
    """Warn, a line each, of statistics that stand on too little of a flight."""
    attrs = statistics.attrs
    n_placed = attrs["n_blocks"] - attrs["n_blocks_not_placed"]
    stands_on = f"{attrs['n_frames']} frames and {n_placed} blocks with layers"
    for name in filter(None, attrs["radiometry_missing"].split(", ")):
        msg = f"{name} is held constant: {stands_on} are too few for it"
        warnings.warn(msg, UserWarning, stacklevel=3)
    n_zones = statistics.sizes["zone"]
    n_needed = n_zones * MINIMUM_BLOCKS
    if n_placed < n_needed:
        msg = f"thickness of {n_zones} zones stands on {n_placed} blocks, {n_needed} are needed"
        warnings.warn(msg, UserWarning, stacklevel=3)
