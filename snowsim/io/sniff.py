"""Which format a file has, told from its content and never from its name."""

from snowsim.io.guard import existing, one_line, refusal
from snowsim.io.hdf5 import names_in_hdf5
from snowsim.io.mat5 import names_in_mat5

HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
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


def container_of(path):
    """How a file keeps its variables, by its first bytes."""
    if path.is_dir():
        if any((path / name).is_file() for name in (".zgroup", ".zmetadata", "zarr.json")):
            return "zarr"
        raise refusal(path, "path", "a file or a Zarr store", "a directory")
    try:
        with path.open("rb") as file:
            head = file.read(4096)
    except OSError as error:
        raise refusal(path, "path", "a readable file", error.strerror) from error
    if head.startswith(b"\x89PNG\r\n\x1a\n"):
        return "png"
    if head.startswith((b"CDF\x01", b"CDF\x02", b"CDF\x05")):
        return "netcdf3"
    # HDF5 lets a block of the user's own stand in front, of 512 bytes times a power of 2; MATLAB writes 512.
    if any(head[at : at + 8] == HDF5_SIGNATURE for at in (0, 512, 1024, 2048)):
        return "hdf5"
    if head[126:128] in (b"IM", b"MI") and head[124:126] in (b"\x00\x01", b"\x01\x00"):
        return "mat5"
    raise refusal(path, "content", "MAT v5, MAT v7.3, NetCDF, PNG or Zarr", f"first bytes {head[:8]!r}")


def names_in(path, container):
    """Names of the variables a file holds."""
    if container == "mat5":
        return names_in_mat5(path)
    if container == "hdf5":
        return names_in_hdf5(path)
    if container == "zarr":
        return {item.name for item in path.iterdir() if item.is_dir()}
    from snowsim.io.netcdf import names_in_netcdf3

    return names_in_netcdf3(path)
