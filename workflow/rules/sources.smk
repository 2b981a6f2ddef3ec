# Source of flight and benchmark: number and names of frames and scenes.

from functools import cache

SOURCE = config["source"]
OWN = config["import"]


def numbered(n):
    """Names of n files."""
    return [f"{i:04d}" for i in range(n)]


# N_OBSERVED scenes of each split lie in files of OBSERVED_PER_SHARD. For own frames both count frames, one in a file,
# since the number of scenes of a frame is known only once it is cut. CHECK is the table of the check of own files.
OBSERVED = or_refused(sources.observed, config, not workflow.is_main_process)
OBSERVED_PER_SHARD = config["benchmark"]["shard_size"]
if SOURCE == "reference":
    SYNTHETIC = "synthetic reference flight, not observed data"
    NOTE = "synthetic reference flight"
    BIN_S = config["reference"]["radar"]["bin_size_s"]
    N_OBSERVED = config["benchmark"]["n_scenes"]
    FRAMES = numbered(config["flight"]["n_frames"])
    SEGMENT = ["results/flight/segment.nc"]
    CHECK = []
else:
    SYNTHETIC = "no"
    NOTE = OWN["description"] or f"source: {SOURCE}"
    BIN_S = OWN["bin_s"]
    N_OBSERVED = {split: len(OBSERVED.get(split, [])) for split in SPLITS}
    SEGMENT = []
    if SOURCE == "png_pairs":
        PAIRS = OWN["pairs"]
        FRAMES = []
        CHECK = "results/tables/scenes.csv"
    else:
        OBSERVED_PER_SHARD = 1
        FRAMES = numbered(len(OBSERVED["statistics"]))
        CHECK = "results/tables/frames.csv"

# Frames that one job draws or summarises, by the number of the shard.
FRAMES_PER_JOB = config["flight"]["frames_per_job"]
FRAME_SHARDS = {
    f"{first // FRAMES_PER_JOB:04d}": FRAMES[first : first + FRAMES_PER_JOB]
    for first in range(0, len(FRAMES), FRAMES_PER_JOB)
}


# A function, so that the table is read only if the target `picks` is asked for.
@cache
def frames_by_job():
    """Frames to track, by the number of the job."""
    jobs = or_refused(sources.frames_to_track, OWN["frames"], FRAMES_PER_JOB)
    sources.keep(OWN["frames"], FRAMES_PER_JOB, jobs)
    return dict(zip(numbered(len(jobs)), jobs))


@cache
def frames_of_job(shard):
    """Frames that a job tracks. Its own process does not read the whole table for them."""
    kept = None
    if not workflow.is_main_process:
        kept = sources.kept(OWN["frames"], FRAMES_PER_JOB, int(shard))
    return kept or frames_by_job()[shard]
