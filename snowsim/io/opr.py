"""Plain arrays to the Open Polar Radar datasets, and the checks both pass on the way out."""

import numpy as np
import xarray as xr

from snowsim.echogram import check_echogram, check_layers
from snowsim.io.guard import refusal

UNITS = {
    "Data": "W (uncalibrated)",
    "Latitude": "degrees_north",
    "Longitude": "degrees_east",
    "Elevation": "m",
    "Surface": "s",
    "Bottom": "s",
    "Roll": "radian",
    "Pitch": "radian",
    "Heading": "radian",
    "twtt": "s",
}
RANGES = {"Latitude": 90, "Longitude": 360}


def echogram_dataset(path, content, attributes):
    """Echogram dataset of `Data` (range_bin, range_line), `twtt`, `slow_time` and values along slow_time; checked."""
    along_track = {name: v for name, v in content.items() if name not in ("Data", "twtt", "slow_time")}
    dataset = xr.Dataset(
        {
            "Data": (("twtt", "slow_time"), content["Data"], {"units": UNITS["Data"]}),
            **{
                name: v if isinstance(v, tuple) else ("slow_time", v, {"units": UNITS[name]})
                for name, v in along_track.items()
            },
        },
        coords={"twtt": ("twtt", content["twtt"], {"units": "s"}), "slow_time": content["slow_time"]},
        attrs={name: value for name, value in attributes.items() if value is not None},
    )
    return checked_echogram(path, dataset)


def checked_echogram(path, dataset):
    """The dataset, if it passes the validator and stays on Earth."""
    check_echogram(dataset, str(path))
    for name, largest in RANGES.items():
        outside = np.abs(dataset[name].values) > largest  # NaN, where the position is unknown, is not outside
        if outside.any():
            found = f"{dataset[name].values[outside][0]:g} at range_line {int(np.argmax(outside))}"
            raise refusal(path, name, f"degrees within +-{largest}", found)
    return dataset


def layers_dataset(path, content, attributes):
    """Layers dataset of `twtt`, `quality`, `type` (layer, slow_time), names and positions along slow_time; checked."""
    along_track = {name: content[name] for name in ("Latitude", "Longitude", "Elevation") if name in content}
    dataset = xr.Dataset(
        {
            "twtt": (("layer", "slow_time"), content["twtt"], {"units": "s"}),
            "quality": (("layer", "slow_time"), content["quality"], {"flag_values": "1 good, 2 moderate, 3 bad"}),
            "type": (("layer", "slow_time"), content["type"], {"flag_values": "1 manual, 2 automatic"}),
            **{name: ("slow_time", values, {"units": UNITS[name]}) for name, values in along_track.items()},
        },
        coords={
            "slow_time": content["slow_time"],
            "layer": ("layer", np.asarray(content["names"], dtype=str)),
            "group": ("layer", np.asarray(content["groups"], dtype=str)),
        },
        attrs={name: value for name, value in attributes.items() if value is not None},
    )
    check_layers(dataset, str(path))
    return dataset
