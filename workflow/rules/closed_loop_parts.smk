# How label sets are divided for the closed loop, and which conventions of PHY go through it.

# One in so many averaged range lines of a scene is kept: the others differ in speckle alone.
LOOP_STRIDE = 6
# Label shards come in parts, for a job takes longer to start than to render a shard. All conventions of PHY go through
# the first part, of about 200 scenes, the one it uses through all of them.
LOOP_FIRST, LOOP_SHARDS = (
    math.ceil(n_scenes / SHARD_SIZE["labels"]) for n_scenes in (200, 650)
)
LOOP_PARTS = [
    shards("labels")[:LOOP_FIRST],
    *[
        shards("labels")[shard : shard + LOOP_SHARDS]
        for shard in range(LOOP_FIRST, len(shards("labels")), LOOP_SHARDS)
    ],
]
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
    convention="(deblended|paper)_(peak|none)_(peak|gaussian)_(fitted|paper)",
    estimator="deblended|paper",
    part=r"\d+",
    parts="first|all",


def loop_statistics(wildcards):
    """The flight's statistics by the estimator of a convention."""
    estimator = wildcards.convention.split("_")[0]
    if estimator == config["statistics"]["estimator"]:
        return "results/statistics.nc"
    return f"results/closed_loop/flight_{estimator}.nc"


def loop_summaries(wildcards):
    """Summaries of the renders of one convention, of the first part or of all."""
    n_parts = 1 if wildcards.parts == "first" else len(LOOP_PARTS)
    return expand(
        "results/closed_loop/{convention}/{part}.nc",
        convention=wildcards.convention,
        part=range(n_parts),
    )
