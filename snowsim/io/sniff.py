"""Which format a file has, determined from its content and never from its name."""

from snowsim.io.containers import names_in
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
# In words, and the variables that it needs. A file is what it has the largest share of; earlier
# entries win a tie.
FORMATS = {
    "nsidc": ("an IRSNO1B echogram", ("amplitude", "fasttime", "time", "lat", "lon", "altitude")),
    "cresis": ("a CReSIS L1B echogram", ("Data", "Time", *POSITION, "GPS_time")),
    "cresis_layer": ("CReSIS layers", ("twtt", "id", "gps_time")),
    "cresis_layer_data": ("old CReSIS layers", ("layerData", "GPS_time")),
    "organizer": ("a CReSIS layer organizer", ("lyr_id", "lyr_name")),
    "opr": ("an Open Polar Radar echogram", ("Data", "slow_time", "twtt", *POSITION)),
    "opr_layers": ("Open Polar Radar layers", ("twtt", "slow_time", "quality", "type")),
    "scenes": ("a set of scenes", ("layer_bins", "n_range_bins", "n_layers")),
    "scene": ("an exported scene", ("layer_bins", "mask")),
    "statistics": ("statistics of a flight", ("peak_power", "variance_bins2", "zone_edge_bins")),
}
ECHOGRAMS = ("nsidc", "cresis", "opr")
LAYERS = ("cresis_layer", "cresis_layer_data", "opr_layers")
# A file that lost half its variables is still called by its name, and what it lacks is named.
SMALLEST_SHARE = 0.4


def sniff(path, kinds=FORMATS):
    """Format of a file, a key of `FORMATS`.

    ValueError if it is none of these `kinds`, or lacks variables of the one that it is.
    """
    names = names_in(path)
    if "UTC_time" in names:
        names.add("GPS_time")  # what older files have in its place
    share = {kind: len(names & {*needed}) / len(needed) for kind, (_, needed) in FORMATS.items()}
    kind = max(share, key=share.get)
    if share[kind] < SMALLEST_SHARE:
        raise refusal(path, "variables", "those of an echogram or of layers", listed(names))
    if kind not in kinds:
        expected = " or ".join(in_words(kind) for kind in kinds)
        raise refusal(path, "format", expected, in_words(kind))
    needed = FORMATS[kind][1]
    missing = ", ".join(name for name in needed if name not in names)
    if missing and kind in (*ECHOGRAMS, *LAYERS):
        raise refusal(path, missing, f"variables {', '.join(needed)}", listed(names))
    return kind


def in_words(kind):
    """A format as messages call it."""
    return FORMATS[kind][0]
