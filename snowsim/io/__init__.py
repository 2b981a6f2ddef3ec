"""Files to datasets and back; the only package that opens files.

Readers are imported where they are called: every job imports this package, and h5py, scipy and
xarray take a second.
"""

import lazy_loader

from snowsim.io.files import library_errors, listed, refusal

# Names beside those below, by the module they are in, loaded at first use.
MODULES = {
    "files": ["read_dataset", "read_table", "write_dataset", "write_table", "written_whole"],
    "frames": ["check_frames", "each_frame", "read_frame", "read_frames"],
    "layers": ["write_layer_files", "write_layers"],
    "models": ["fingerprint", "read_model", "read_tracker", "write_model"],
    "pairs": [
        "PairSet",
        "export_netcdf",
        "export_pairs",
        "layer_numbers",
        "layers_of_labels",
        "read_image",
        "read_mask",
        "read_pair",
        "write_image",
    ],
    "pictures": ["write_picture"],
    "profiles": ["Profile", "read_profile"],
    "scenes": ["SceneSet", "write_scenes"],
}
__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submod_attrs=MODULES)
__all__ += ["echogram", "open_segment", "read_echogram", "read_layers"]


def read_echogram(path, *, compensated=False, source=None):
    """Echogram dataset of a file, whose format is determined from its content.

    Parameters
    ----------
    path : path_like
        IRSNO1B NetCDF (plain, deconv, uwb), CReSIS L1B MAT (v5, v7.3), or an Open Polar Radar
        dataset (NetCDF, Zarr).
    compensated : bool
        Keep elevation compensation where a file has it; by default travel times are those to the
        antenna's `Elevation`.
    source : {"nsidc", "cresis", "opr"}, optional
        Format that the file must have; by default any of these.

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
    A simulated frame, written as Open Polar Radar dataset:

    >>> from snowsim import Climate, simulate
    >>> drawn, _ = simulate(Climate(accumulation_m=0.3), "snow-2012", n_range_lines=64, rng=1)
    >>> _ = drawn.to_netcdf("frame.nc")
    >>> echogram = read_echogram("frame.nc")
    >>> echogram.sizes["slow_time"], echogram["twtt"].attrs["units"]
    (64, 's')
    """
    from snowsim.io import containers, echograms

    stored = containers.opened(path)
    with library_errors(stored.path):
        kinds = [source] if source else containers.ECHOGRAMS
        kind = containers.format_of(stored, kinds)
        if kind == "opr":
            return echograms.read_opr(stored)
        read = echograms.read_nsidc if kind == "nsidc" else echograms.read_cresis
        return read(stored, compensated=compensated)


def echogram(data, *, twtt, slow_time=None, attrs=None, **along_track):
    """Echogram dataset of arrays in memory, as `read_echogram` gives them of a file.

    Parameters
    ----------
    data : array_like, (range_bin, range_line)
        Linear power, NaN where nothing was recorded.
    twtt : array_like, (range_bin,)
        Two-way travel time of the range bins, evenly spaced [s].
    slow_time : array_like of datetime64, (range_line,), optional
        UTC; by default range lines follow one another by a millisecond, from 2000 on.
    attrs : dict, optional
        Attributes of the dataset.
    **along_track : array_like, (range_line,)
        `Latitude`, `Longitude` [deg], `Elevation` [m], `Surface` and `Bottom` (travel times) [s],
        `Roll`, `Pitch`, `Heading` [radian]; the first four are NaN by default.

    Returns
    -------
    xarray.Dataset
        As of `read_echogram`.

    Raises
    ------
    ValueError
        In one line: names that are not known, lengths that do not agree, power that is negative or
        looks like grey levels.

    Examples
    --------
    >>> import numpy as np
    >>> power = np.random.default_rng(1).gamma(4, 0.25, size=(300, 64))
    >>> frame = echogram(power, twtt=3e-6 + 2.886e-10 * np.arange(300))
    >>> dict(frame.sizes), int(frame["Surface"].isnull().sum())
    ({'twtt': 300, 'slow_time': 64}, 64)
    """
    import numpy as np

    from snowsim.io.echograms import UNITS, echogram_dataset

    where = "echogram"
    with library_errors(where, "data: expected an array (range_bin, range_line)"):
        if along_track.keys() - UNITS.keys():
            raise refusal(where, "names", listed(UNITS), listed(along_track))
        content = {"Data": np.asarray(data), "twtt": twtt} | along_track
        if slow_time is not None:
            content["slow_time"] = np.asarray(slow_time)
        return echogram_dataset(where, content, attrs or {})


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
    >>> from snowsim import Climate, simulate
    >>> _, drawn = simulate(Climate(accumulation_m=0.3), "snow-2012", n_range_lines=64, rng=1)
    >>> _ = drawn.to_netcdf("layers.nc")
    >>> layers = read_layers("layers.nc")
    >>> layers["twtt"].dims, int(layers["layer"][0])
    (('layer', 'slow_time'), 0)
    """
    from snowsim.echogram import check_choice
    from snowsim.io import containers, layers

    check_choice("missing", missing, ("refuse", "skip"))
    readers = {
        "cresis_layer": layers.read_cresis_layers,
        "cresis_layer_data": layers.read_cresis_layer_data,
        "opr_layers": layers.read_opr_layers,
    }
    names = [names] if isinstance(names, str) else names
    stored = containers.opened(path)
    with library_errors(stored.path):
        kind = containers.format_of(stored, readers)
        return layers.chosen(readers[kind](stored), names, missing, stored.path)


def open_segment(paths):
    """Layers of the frames of a segment as one dataset, frames in order of their times.

    Parameters
    ----------
    paths : iterable of path_like
        Files that `read_layers` reads, such as the `NAME_layers.nc` of `snowsim track`.

    Returns
    -------
    xarray.Dataset
        As of `read_layers`; a layer of the same name is the same in all frames, NaN where a frame
        lacks it. Layers come by their names: the surface, then by number. `frame` along slow_time
        is the name of the file.

    Raises
    ------
    ValueError
        In one line: no file, one that `read_layers` refuses, or frames that overlap in time.
    """
    import itertools
    from pathlib import Path

    import numpy as np
    import xarray as xr

    from snowsim.echogram import check_layers
    from snowsim.io.layers import AUTOMATIC, GOOD, SURFACE

    paths = list(paths)
    where = "segment"
    if not paths:
        raise refusal(where, "files", "those of its frames", "none")
    frames = []
    for path in paths:
        layers = read_layers(path)
        frame = Path(path).stem.removesuffix("_layers")
        names = ("slow_time", np.full(layers.sizes["slow_time"], frame, dtype=object))
        frames.append(layers.assign_coords(frame=names))
    frames.sort(key=lambda frame: frame["slow_time"].values[0])
    for first, second in itertools.pairwise(frames):
        if second["slow_time"].values[0] <= first["slow_time"].values[-1]:
            names = " and ".join(str(each["frame"].values[0]) for each in (first, second))
            raise refusal(where, names, "frames that follow one another", "frames overlap in time")
    joined = xr.concat(
        frames,
        "slow_time",
        data_vars="all",
        coords="minimal",
        compat="override",
        join="outer",
        fill_value={"quality": GOOD, "type": AUTOMATIC},
        combine_attrs="drop_conflicts",
    )
    names = joined["layer"].values
    in_order = sorted(names, key=lambda name: (name != SURFACE, len(str(name)), name))
    joined = joined.sel(layer=in_order)
    check_layers(joined, f"{where} of {paths[0]}")
    return joined
