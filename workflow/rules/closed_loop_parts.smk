# How label sets are divided for the closed loop, and which conventions of PHY go through it.

# One in so many averaged range lines of a scene is kept: the others differ in speckle alone.
LOOP_STRIDE = 6
# All conventions of PHY are tried on the first scenes, in a job each. The one it uses goes through all of them in parts;
# parts count scenes, so tables do not depend on shards.
LOOP_FIRST, LOOP_SCENES = 200, 650
LOOP_STARTS = [0, *range(LOOP_FIRST, N_SCENES["labels"], LOOP_SCENES)]
LOOP_PARTS = list(zip(LOOP_STARTS, [*LOOP_STARTS[1:], N_SCENES["labels"]]))
LOOP_DEFAULT = "{}_{normalise}_{align}_{width}".format(
    config["statistics"]["estimator"], **config["phy"]
)
LOOP_CONVENTIONS = list(
    dict.fromkeys(
        [
            LOOP_DEFAULT,
            "deblended_peak_peak_fitted",
            "deblended_none_peak_fitted",
            "deblended_peak_gaussian_fitted",
            "deblended_peak_peak_paper",
            "paper_none_gaussian_paper",  # as printed, estimates and all
        ]
    )
)


wildcard_constraints:
    convention="|".join(LOOP_CONVENTIONS),
    estimator="deblended|paper",
    part=r"\d+",


def loop_shards(part):
    """Label shards that hold the scenes of a part, and at which scene the first of them begins."""
    start, stop = LOOP_PARTS[part]
    held = [
        shard
        for shard in shards("labels")
        if shard_range("labels", shard)[0] < stop
        and shard_range("labels", shard)[1] > start
    ]
    return held, shard_range("labels", held[0])[0]


def loop_labels(part):
    """Files of the label scenes of a part."""
    return expand("results/labels/{shard}.nc", shard=loop_shards(part)[0])


def loop_statistics(wildcards):
    """The flight's statistics by the estimator of a convention."""
    estimator = wildcards.convention.split("_")[0]
    if estimator == config["statistics"]["estimator"]:
        return "results/statistics.nc"
    return f"results/closed_loop/flight_{estimator}.nc"
