"""Open Polar Radar datasets on disk, NetCDF or Zarr: those of xopr and of this project's own flight."""

import importlib.util

import numpy as np
import xarray as xr

from snowsim.echogram import ECHOGRAM_ALONG_TRACK, check_layers
from snowsim.io.containers import read_netcdf
from snowsim.io.datasets import checked_echogram
from snowsim.io.guard import check_size, existing, library_errors, refusal
from snowsim.io.layers import order_from_surface

UNITS_OF_TWTT = ("", "s", "sec", "second", "seconds")


def read_opr(path):
    """Echogram dataset as it stands on disk, with dimensions put in the order (twtt, slow_time); checked."""
    path = existing(path, directory=True)
    dataset = _load(path)
    _need(path, dataset, ("Data", "twtt", "slow_time", *ECHOGRAM_ALONG_TRACK))
    _check_unit(path, dataset)
    _check_real(path, dataset, ("Data", "twtt", *ECHOGRAM_ALONG_TRACK))
    if set(dataset["Data"].dims) != {"twtt", "slow_time"}:
        raise refusal(path, "Data", "dimensions twtt and slow_time", ", ".join(map(str, dataset["Data"].dims)))
    return checked_echogram(path, dataset.transpose("twtt", "slow_time", ...))


def read_opr_layers(path, *, names=None, missing="refuse"):
    """Layers dataset as it stands on disk, (layer, slow_time); checked.

    A single layer without a `layer` dimension gets one. Layers with names are ordered from the surface down; numbered
    ones keep their order, the first being the surface. `names` selects layers by the values of `layer`; a name the
    file does not have is refused, or left out where `missing` is "skip".
    """
    path = existing(path, directory=True)
    dataset = _load(path)
    _need(path, dataset, ("twtt", "slow_time", "quality", "type"))
    _check_unit(path, dataset)
    _check_real(path, dataset, ("twtt", "quality", "type"))
    single = [name for name in ("twtt", "quality", "type") if dataset[name].dims == ("slow_time",)]
    if single:
        dataset = dataset.assign({name: dataset[name].expand_dims("layer") for name in single})
    for name in ("twtt", "quality", "type"):
        if set(dataset[name].dims) != {"layer", "slow_time"}:
            raise refusal(path, name, "dimensions layer and slow_time", ", ".join(map(str, dataset[name].dims)))
    dataset = dataset.transpose("layer", "slow_time", ...)
    labelled = "layer" in dataset.coords and dataset["layer"].dtype.kind in "OUS"
    if names is not None:
        labels = [str(label) for label in dataset["layer"].values]
        for name in names:
            if str(name) not in labels and missing == "refuse":
                raise refusal(path, "layer", f"one named {name}", ", ".join(labels))
        dataset = dataset.isel(layer=[i for i, label in enumerate(labels) if label in set(map(str, names))])
    if labelled:
        picked = np.isfinite(dataset["twtt"].values).any(axis=1)
        dataset = dataset.isel(layer=np.flatnonzero(picked))
        labels = [str(label) for label in dataset["layer"].values]
        dataset = dataset.isel(layer=order_from_surface(dataset["twtt"].values, labels, path))
    if not np.isfinite(dataset["twtt"].values).any():
        raise refusal(path, "twtt", "at least one layer with picks", "only NaN")
    check_layers(dataset, str(path))
    return dataset


def _load(path):
    """The dataset in memory, its times decoded."""
    if not path.is_dir():
        dataset = read_netcdf(path)
        with library_errors(path, "dataset", "times and fill values that can be decoded"):
            return xr.decode_cf(dataset, decode_timedelta=False).load()
    if importlib.util.find_spec("zarr") is None:
        raise refusal(path, "Zarr store", "package zarr to read it", "it is not installed")
    with (
        library_errors(path, "dataset", "a readable store"),
        xr.open_dataset(path, engine="zarr", decode_timedelta=False) as dataset,
    ):
        for name, variable in dataset.variables.items():
            check_size(path, name, variable.shape, variable.dtype.itemsize)
        return dataset.load()


def _need(path, dataset, names):
    for name in names:
        if name not in dataset.variables:
            found = ", ".join(map(str, dataset.variables)) or "none"
            raise refusal(path, name, f"variables {', '.join(names)}", found)


def _check_unit(path, dataset):
    unit = str(dataset["twtt"].attrs.get("units", ""))
    if unit not in UNITS_OF_TWTT:
        raise refusal(path, "twtt", "seconds", unit)


def _check_real(path, dataset, names):
    for name in names:
        if dataset[name].dtype.kind not in "fiu":
            raise refusal(path, name, "real numbers", dataset[name].dtype)
