"""Which format a file has, determined from its content and never from its name."""

from snowsim.io.containers import PIXELS, names_in
from snowsim.io.guard import listed, refusal

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
POSITION = ("Latitude", "Longitude", "Elevation")
# In words, and the variables that make it. A file is what it has the largest share of; earlier
# entries win a tie.
FORMATS = {
    "nsidc": ("an IRSNO1B echogram", ("amplitude", "fasttime", "time", "lat", "lon", "altitude")),
    "cresis": ("a CReSIS L1B echogram", ("Data", "Time", "GPS_time", "Surface", *POSITION)),
    "cresis_layer": ("CReSIS layers", ("twtt", "id", "gps_time", "lat", "lon", "elev")),
    "cresis_layer_data": ("old CReSIS layers", ("layerData", "GPS_time")),
    "organizer": ("a CReSIS layer organizer", ("lyr_id", "lyr_name", "lyr_order")),
    "opr": (
        "an Open Polar Radar echogram",
        ("Data", "slow_time", "twtt", "Surface", *POSITION),
    ),
    "opr_layers": ("Open Polar Radar layers", ("twtt", "slow_time", "quality", "type")),
    "supplement": ("an IRSNO1B supplement", SUPPLEMENT_FLAGS),
    "scenes": ("a set of scenes", ("layer_bins", "n_range_bins", "n_layers")),
    "scene": ("an exported scene", ("layer_bins", "image")),
    "statistics": (
        "statistics of a flight",
        ("peak_power", "variance_bins2", "zone_edge_bins"),
    ),
    "png": ("a PNG image", (PIXELS,)),
    "pair": ("a benchmark pair", ("data", "layer")),
}
ECHOGRAMS = ("nsidc", "cresis", "opr")
# A file that lost half its variables is still called by its name, and what it lacks is named.
SMALLEST_SHARE = 0.4


def sniff(path):
    """Format of a file, a key of `FORMATS`; ValueError if it is none of them."""
    names = names_in(path)
    share = {
        kind: len(names.intersection(wanted)) / len(wanted) for kind, (_, wanted) in FORMATS.items()
    }
    kind = max(share, key=share.get)
    if share[kind] < SMALLEST_SHARE:
        raise refusal(path, "variables", "those of an echogram or of layers", listed(names))
    return kind


def in_words(kind):
    """A format as messages call it."""
    return FORMATS[kind][0]
