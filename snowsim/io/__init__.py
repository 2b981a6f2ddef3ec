"""Files to datasets and back; the only package that opens files.

Readers are imported where they are called: every job imports this package, and h5py, scipy and
xarray take a second.
"""

from snowsim.io.guard import refusal


def read_echogram(path, *, compensated=False):
    """Echogram dataset of a file, whose format is determined from its content.

    Parameters
    ----------
    path : path_like
        IRSNO1B NetCDF (plain, deconv, uwb), CReSIS L1B MAT (v5, v7.3), or an Open Polar Radar
        dataset (NetCDF, Zarr).
    compensated : bool
        Keep elevation compensation where a file has it; by default travel times are those to the
        antenna's `Elevation`.

    Returns
    -------
    xarray.Dataset
        Coordinates `slow_time` [UTC] and `twtt` [s]; `Data` (twtt, slow_time) in linear power, NaN
        where nothing was recorded; `Latitude`, `Longitude`, `Elevation`, `Surface` along slow_time,
        and what else the file has.

    Raises
    ------
    ValueError
        One line, with file, variable, expected and found, for any file that is not a sound
        echogram.

    Examples
    --------
    A frame of the synthetic reference flight, written as Open Polar Radar dataset:

    >>> import numpy as np
    >>> from snowsim.reference import checked_settings, draw_climate, draw_frame
    >>> settings = checked_settings({"radar": {"n_range_bins": 300}})
    >>> rng = np.random.default_rng(1)
    >>> climate = draw_climate(settings, rng=rng)
    >>> drawn, layers = draw_frame(0, 1, 64, climate=climate, settings=settings, rng=rng)
    >>> _ = drawn.to_netcdf("frame.nc")
    >>> echogram = read_echogram("frame.nc")
    >>> dict(echogram.sizes), echogram["twtt"].attrs["units"]
    ({'twtt': 300, 'slow_time': 64}, 's')
    """
    from snowsim.io import cresis, datasets, nsidc, sniff

    kind = sniff.sniff(path)
    if kind == "nsidc":
        return nsidc.read_nsidc(path, compensated=compensated)
    if kind == "cresis":
        return cresis.read_cresis(path, compensated=compensated)
    if kind == "opr":
        return datasets.read_opr(path)
    expected = "an echogram (IRSNO1B, CReSIS L1B or Open Polar Radar)"
    raise refusal(path, "format", expected, sniff.in_words(kind))


def read_layers(path, *, names=None, missing="refuse"):
    """Layers dataset of a file, whose format is determined from its content.

    Parameters
    ----------
    path : path_like
        CReSIS layer file, new (names from the organizer file beside it) or old, or an Open Polar
        Radar layers dataset.
    names : iterable of str, optional
        Read these layers only, such as ``["surface", "Koenig_2"]``.
    missing : {"refuse", "skip"}
        What becomes of a file that has no layer of one of the `names`.

    Returns
    -------
    xarray.Dataset
        `twtt` [s], `quality`, `type` on (layer, slow_time), from the snow surface down; `layer`
        holds the names.

    Raises
    ------
    ValueError
        One line, with file, variable, expected and found, for any file that is not a sound set of
        layers; also where no layer has a pick, or where layers cross.

    Examples
    --------
    >>> import numpy as np
    >>> from snowsim.reference import checked_settings, draw_climate, draw_frame
    >>> settings = checked_settings({"radar": {"n_range_bins": 300}})
    >>> rng = np.random.default_rng(1)
    >>> climate = draw_climate(settings, rng=rng)
    >>> echogram, drawn = draw_frame(0, 1, 64, climate=climate, settings=settings, rng=rng)
    >>> _ = drawn.to_netcdf("layers.nc")
    >>> layers = read_layers("layers.nc")
    >>> layers["twtt"].dims, int(layers["layer"][0])
    (('layer', 'slow_time'), 0)
    """
    from snowsim.io import layers, sniff

    readers = {
        "cresis_layer": layers.read_cresis_layers,
        "cresis_layer_data": layers.read_cresis_layer_data,
        "opr_layers": layers.read_opr_layers,
    }
    kind = sniff.sniff(path)
    if kind not in readers:
        raise refusal(path, "format", "layers (CReSIS or Open Polar Radar)", sniff.in_words(kind))
    names = [names] if isinstance(names, str) else names
    return readers[kind](path, names=names, missing=missing)
