# From summaries of the flight to its statistics, and from these to label sets.


rule fit_statistics:
    input:
        # One for each shard of frames or, where there are only images, for each file of train scenes.
        summaries=expand("results/statistics/{shard}.nc", shard=FRAME_SHARDS or shards("train")),
        segment=SEGMENT,
    output:
        statistics="results/statistics.nc",
    log:
        "logs/fit_statistics.log",
    benchmark:
        "results/benchmarks/fit_statistics/all.tsv"
    resources:
        mem_mb=1500,
    params:
        # The printed label sets are drawn from the printed statistics.
        estimator={"measured": "deblended", "paper": "paper"}[LABELS["recipe"]],
    message:
        "flight statistics"
    script:
        "../scripts/fit_statistics.py"


rule draw_labels:
    input:
        statistics="results/statistics.nc",
    output:
        labels="results/labels/{shard}.nc",
    log:
        "logs/draw_labels/{shard}.log",
    benchmark:
        "results/benchmarks/draw_labels/{shard}.tsv"
    resources:
        results_mb=lambda w: scenes_mb("labels", w.shard, 18),
    params:
        seed=config["seed"],
        span=lambda w: shard_range("labels", w.shard),
        labels={key: LABELS[key] for key in LABELS if key not in ("n_scenes", "shard_size")},
    message:
        "label sets, shard {wildcards.shard}"
    script:
        str(ROOT / "workflow/scripts/draw_labels.py")


rule labels:
    input:
        expand("results/labels/{shard}.nc", shard=shards("labels")),
    message:
        "all label sets"
