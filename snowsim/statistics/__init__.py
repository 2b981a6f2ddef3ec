"""Flight statistics from annotated frames: summarise each, merge in any order, estimate once."""

from snowsim.statistics.estimate import ESTIMATORS, estimate
from snowsim.statistics.speckle import doppler_spectra
from snowsim.statistics.summaries import merge, summarise, summary_from_dataset, summary_to_dataset

__all__ = ["ESTIMATORS", "doppler_spectra", "estimate", "fit", "merge", "summarise"]
__all__ += ["summary_from_dataset", "summary_to_dataset"]


def fit(frames, *, estimator="deblended"):
    """Statistics of a flight.

    Frames are read one at a time, in any order; each leaves a summary of about 0.4 kB per range
    line.

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
        If there is no frame, bin sizes differ, a dataset breaks the convention, or `estimate`
        refuses the flight.

    Examples
    --------
    Two frames of the synthetic reference flight:

    >>> import numpy as np
    >>> from snowsim.reference import checked_settings, draw_climate, draw_frame
    >>> settings = checked_settings({"radar": {"n_range_bins": 300}})
    >>> climate = draw_climate(settings, rng=np.random.default_rng(1))
    >>> common = {"climate": climate, "settings": settings}
    >>> frames = (draw_frame(i, 2, 512, **common, rng=np.random.default_rng(i)) for i in range(2))
    >>> statistics = fit(frames, estimator="paper")
    >>> statistics["thickness_psd"].dims
    ('zone', 'slab', 'wavenumber')
    >>> statistics.attrs["n_frames"]
    2
    >>> bool(statistics["peak_power"][0] > statistics["peak_power"][1])
    True
    """
    return estimate(
        merge(summarise(*frame, where=f"frame {i}") for i, frame in enumerate(frames)),
        estimator=estimator,
    )
