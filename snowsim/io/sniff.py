"""Which format a file has, told from its content and never from its name."""

from snowsim.io.containers import names_in_hdf5
from snowsim.io.guard import container_of, existing, one_line, refusal
from snowsim.io.matlab import names_in_mat5

SUPPLEMENT_FLAGS = (
    "coh_noise_removal_artifact",
    "deconvolution_artifact",
    "vertical_stripes_artifact",
    "missing_data",
    "no_good_data",
    "low_SNR",
    "unclassified_artifact",
    "land_ice",
)

# The variables that make a format; a file is what it has the largest share of, earlier entries winning a tie.
FORMATS = {
    "nsidc": ("amplitude", "fasttime", "time", "lat", "lon", "altitude"),
    "cresis": ("Data", "Time", "GPS_time", "Latitude", "Longitude", "Elevation", "Surface"),
    "cresis_layer": ("twtt", "id", "gps_time", "lat", "lon", "elev"),
    "cresis_layer_data": ("layerData", "GPS_time"),
    "organizer": ("lyr_id", "lyr_name", "lyr_order"),
    "opr": ("Data", "slow_time", "twtt", "Latitude", "Longitude", "Elevation", "Surface"),
    "opr_layers": ("twtt", "slow_time", "quality", "type"),
    "supplement": SUPPLEMENT_FLAGS,
    "scenes": ("layer_bins", "n_range_bins", "n_layers"),
    "scene": ("layer_bins", "image"),
    "pair": ("data", "layer"),
}
IN_WORDS = {
    "nsidc": "an IRSNO1B echogram",
    "cresis": "a CReSIS L1B echogram",
    "cresis_layer": "CReSIS layers",
    "cresis_layer_data": "old CReSIS layers",
    "organizer": "a CReSIS layer organizer",
    "opr": "an Open Polar Radar echogram",
    "opr_layers": "Open Polar Radar layers",
    "supplement": "an IRSNO1B supplement",
    "scenes": "a set of scenes",
    "scene": "an exported scene",
    "pair": "a benchmark pair",
    "png": "a PNG image",
}
SMALLEST_SHARE = 0.4  # a file that lost half its variables is still called by its name, and told what it lacks


def sniff(path):
    """Container and format of a file.

    Parameters
    ----------
    path : path_like

    Returns
    -------
    container : {"mat5", "hdf5", "netcdf3", "png", "zarr"}
        MAT v7.3 and NetCDF-4 are both HDF5.
    kind : str
        A key of `FORMATS`; "png" for an image.

    Raises
    ------
    ValueError
        If there is no such file, or it is none of these.
    """
    path = existing(path, directory=True)
    container = container_of(path)
    if container == "png":
        return container, "png"
    names = names_in(path, container)
    share = {kind: sum(name in names for name in wanted) / len(wanted) for kind, wanted in FORMATS.items()}
    kind = max(share, key=share.get)
    if share[kind] < SMALLEST_SHARE:
        found = one_line(", ".join(sorted(names)) or "none", 200)
        raise refusal(path, "variables", "those of an echogram or of layers", found)
    return container, kind


def names_in(path, container):
    """Names of the variables a file holds."""
    if container == "mat5":
        return names_in_mat5(path)
    if container == "hdf5":
        return names_in_hdf5(path)
    if container == "zarr":
        return {item.name for item in path.iterdir() if item.is_dir()}
    from snowsim.io.containers import names_in_netcdf3

    return names_in_netcdf3(path)
