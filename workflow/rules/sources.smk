# Where flight and benchmark come from: how many frames and scenes there are, and what is said of them.

from snakemake.logging import logger

# Rules that make the flight and the benchmark, by source.
FLIGHT_RULES = {
    "reference": "flight",
    "nsidc": "import_frames",
    "cresis": "import_frames",
    "opr": "import_frames",
    "png_pairs": "import_pairs",
}
# What a source cannot give, and why.
LEFT_OUT = {
    "reference": {},
    **dict.fromkeys(
        ("nsidc", "cresis", "opr"),
        {
            "realism": "it holds the synthetic flight against observed values",
            "Doppler spectra": "files of detected power hold no phase",
        },
    ),
    "png_pairs": {
        "realism": "it holds the synthetic flight against observed values",
        "Doppler spectra": "images hold no phase",
        "map and echogram of the flight": "images tell no positions; statistics come from the train scenes",
    },
}
SOURCE = config["source"]
OWN = config["import"]


def read_own(read, *arguments, **options):
    """What a reader of the package gives; its complaint as that of the workflow."""
    try:
        return read(*arguments, **options)
    except ValueError as error:
        raise WorkflowError(str(error))


def own_frames():
    """The table of frames, each role's rows numbered from 0."""
    from snowsim.io.frame_table import read_frames

    table = read_own(read_frames, OWN["frames"])
    for role in ("statistics", "train", "test"):
        if role not in set(table["role"]):
            raise WorkflowError(
                f"{OWN['frames']}: role: expected at least one frame for {role}, found none"
            )
    return {role: rows.to_dict("records") for role, rows in table.groupby("role")}


def own_pairs():
    """Scenes of each split by its list file, none of them in two."""
    from snowsim.io.png_pairs import PairSet

    folder, lists = OWN["pairs"]["folder"], OWN["pairs"]["lists"]
    if folder is None:
        raise WorkflowError(
            "config: import.pairs.folder: expected a folder of the published benchmark, got null"
        )
    pairs = {
        split: read_own(
            PairSet, Path(folder) / name, data_scale=OWN["pairs"]["data_scale"]
        )
        for split, name in lists.items()
        if name is not None
    }
    seen = {}
    for split, scenes in pairs.items():
        for scene in scenes.names:
            if scene in seen:
                raise WorkflowError(
                    f"{folder}: {lists[split]}: expected scenes that are in no other list, "
                    f"found {scene} in {lists[seen[scene]]} too"
                )
            seen[scene] = split
    return pairs


def numbered(n):
    """Names of n files."""
    return [f"{i:04d}" for i in range(n)]


FRAMES_PER_JOB = config["flight"]["frames_per_job"]
# N_OBSERVED scenes of each split lie in files of OBSERVED_PER_SHARD. How many scenes an own frame gives is known when it
# is cut: there a file holds one frame, and frames are counted.
if SOURCE == "reference":
    SYNTHETIC = "synthetic reference flight, not observed data"
    NOTE = "synthetic reference flight"
    N_OBSERVED = config["benchmark"]["n_scenes"]
    OBSERVED_PER_SHARD = config["benchmark"]["shard_size"]
    FRAMES = numbered(config["flight"]["n_frames"])
    SEGMENT = ["results/flight/segment.nc"]
else:
    for what, reason in LEFT_OUT[SOURCE].items():
        logger.info(f"source {SOURCE}: left out: {what}: {reason}")
    SYNTHETIC = "no"
    NOTE = OWN["description"] or f"source: {SOURCE}"
    SEGMENT = []
    if SOURCE == "png_pairs":
        PAIRS = own_pairs()
        N_OBSERVED = {split: len(PAIRS.get(split, [])) for split in SPLITS}
        OBSERVED_PER_SHARD = config["benchmark"]["shard_size"]
        FRAMES = []
    else:
        OWN_FRAMES = own_frames()
        N_OBSERVED = {split: len(OWN_FRAMES.get(split, [])) for split in SPLITS}
        OBSERVED_PER_SHARD = 1
        FRAMES = numbered(len(OWN_FRAMES["statistics"]))

# Frames that one job draws or sums up, by the number of the lot.
FRAME_LOTS = {
    f"{first // FRAMES_PER_JOB:04d}": FRAMES[first : first + FRAMES_PER_JOB]
    for first in range(0, len(FRAMES), FRAMES_PER_JOB)
}
