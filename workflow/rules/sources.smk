# Where flight and benchmark come from: how many frames and scenes there are, and what they are called.

from lib import sources

SOURCE = config["source"]
OWN = config["import"]


def frame_inputs(row_of):
    """Inputs of a rule that imports the frame of a row of the table; `row_of` is given wildcards."""
    return {
        "echogram": lambda w: row_of(w)["echogram"],
        "layers": lambda w: row_of(w)["layers"],
        "unread": lambda w: [CHECK, *sources.frame_files(row_of(w), SOURCE)],
    }


def numbered(n):
    """Names of n files."""
    return [f"{i:04d}" for i in range(n)]


# N_OBSERVED scenes of each split lie in files of OBSERVED_PER_SHARD. How many scenes an own frame gives is known when it
# is cut: there a file holds one frame, and frames are counted. CHECK is the table of the check of own files.
if SOURCE == "reference":
    or_refused(sources.check_reference, config["reference"], config["flight"])
    SYNTHETIC = "synthetic reference flight, not observed data"
    NOTE = "synthetic reference flight"
    N_OBSERVED = config["benchmark"]["n_scenes"]
    OBSERVED_PER_SHARD = config["benchmark"]["shard_size"]
    FRAMES = numbered(config["flight"]["n_frames"])
    SEGMENT = ["results/flight/segment.nc"]
    CHECK = []
else:
    SYNTHETIC = "no"
    NOTE = OWN["description"] or f"source: {SOURCE}"
    SEGMENT = []
    if SOURCE == "png_pairs":
        PAIRS = OWN["pairs"]
        OBSERVED = or_refused(
            sources.own_pairs, PAIRS["folder"], PAIRS["lists"], PAIRS["data_scale"]
        )
        OBSERVED_PER_SHARD = config["benchmark"]["shard_size"]
        FRAMES = []
        CHECK = "results/tables/scenes.csv"
    else:
        OBSERVED = or_refused(sources.own_frames, OWN["frames"])
        OBSERVED_PER_SHARD = 1
        FRAMES = numbered(len(OBSERVED["statistics"]))
        CHECK = "results/tables/frames.csv"
    N_OBSERVED = {split: len(OBSERVED.get(split, [])) for split in SPLITS}

# Frames that one job draws or sums up, by the number of the shard.
FRAMES_PER_JOB = config["flight"]["frames_per_job"]
FRAME_SHARDS = {
    f"{first // FRAMES_PER_JOB:04d}": FRAMES[first : first + FRAMES_PER_JOB]
    for first in range(0, len(FRAMES), FRAMES_PER_JOB)
}
