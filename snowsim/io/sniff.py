"""Which format a file has, determined from its content and never from its name."""

from snowsim.echogram import ECHOGRAM_ALONG_TRACK
from snowsim.io.containers import names_in_hdf5, names_in_netcdf3
from snowsim.io.guard import container_of, existing, listed, refusal
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
# In words, and the variables that make it. A file is what it has the largest share of; earlier
# entries win a tie.
FORMATS = {
    "nsidc": ("an IRSNO1B echogram", ("amplitude", "fasttime", "time", "lat", "lon", "altitude")),
    "cresis": ("a CReSIS L1B echogram", ("Data", "Time", "GPS_time", *ECHOGRAM_ALONG_TRACK)),
    "cresis_layer": ("CReSIS layers", ("twtt", "id", "gps_time", "lat", "lon", "elev")),
    "cresis_layer_data": ("old CReSIS layers", ("layerData", "GPS_time")),
    "organizer": ("a CReSIS layer organizer", ("lyr_id", "lyr_name", "lyr_order")),
    "opr": ("an Open Polar Radar echogram", ("Data", "slow_time", "twtt", *ECHOGRAM_ALONG_TRACK)),
    "opr_layers": ("Open Polar Radar layers", ("twtt", "slow_time", "quality", "type")),
    "supplement": ("an IRSNO1B supplement", SUPPLEMENT_FLAGS),
    "scenes": ("a set of scenes", ("layer_bins", "n_range_bins", "n_layers")),
    "scene": ("an exported scene", ("layer_bins", "image")),
    "statistics": (
        "statistics of a flight",
        ("peak_power", "variance_bins2", "thickness_psd", "zone_edge_bins"),
    ),
    "pair": ("a benchmark pair", ("data", "layer")),
}
ECHOGRAMS = ("nsidc", "cresis", "opr")
# A file that lost half its variables is still called by its name, and what it lacks is named.
SMALLEST_SHARE = 0.4


def sniff(path):
    """Format of a file: a key of `FORMATS`, or "png" for an image; ValueError if it is none."""
    path = existing(path, directory=True)
    if container_of(path) == "png":
        return "png"
    names = names_in(path)
    share = {}
    for kind, (_, wanted) in FORMATS.items():
        share[kind] = len(names.intersection(wanted)) / len(wanted)
    kind = max(share, key=share.get)
    if share[kind] < SMALLEST_SHARE:
        raise refusal(path, "variables", "those of an echogram or of layers", listed(names))
    return kind


def in_words(kind):
    """A format as messages call it."""
    return "a PNG image" if kind == "png" else FORMATS[kind][0]


def names_in(path):
    """Names of the variables a file holds."""
    container = container_of(path)
    if container == "zarr":
        return {item.name for item in path.iterdir() if item.is_dir()}
    if container == "mat5":
        return names_in_mat5(path)
    if container == "netcdf3":
        return names_in_netcdf3(path)
    return names_in_hdf5(path)
