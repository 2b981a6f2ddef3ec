# Diagnostics of renders of label sets: how often a network tells them from observed scenes, what statistics they give.

DRAWN_SHARDS = first_shards(config["drawn_scenes"]["n_scenes"])


rule compare_scenes:
    input:
        observed=benchmark_files("train"),
        phy=expand("results/phy/labels/{shard}.nc", shard=DRAWN_SHARDS),
        cgan=expand("results/cgan/labels/{shard}.nc", shard=DRAWN_SHARDS),
    output:
        two_sample="results/tables/two_sample.csv",
    log:
        "logs/compare_scenes.log",
    benchmark:
        "results/benchmarks/compare_scenes/all.tsv"
    resources:
        mem_mb=2000,
    params:
        **config["drawn_scenes"],
        seed=config["seed"],
    message:
        "drawn scenes beside observed ones: can they be distinguished"
    script:
        "../scripts/compare_scenes.py"


rule render_closed_loop:
    input:
        layers="results/labels/{shard}.nc",
        statistics="results/statistics.nc",
    output:
        summary=temp("results/closed_loop/{shard}.nc"),
    log:
        "logs/render_closed_loop/{shard}.log",
    benchmark:
        "results/benchmarks/render_closed_loop/{shard}.tsv"
    params:
        seed=config["seed"],
        phy=config["phy"],
        first=lambda wildcards: shard_range("labels", wildcards.shard)[0],
    message:
        "sums over renders, shard {wildcards.shard}"
    script:
        "../scripts/render_closed_loop.py"


rule tabulate_closed_loop:
    input:
        summaries=expand("results/closed_loop/{shard}.nc", shard=shards("labels")),
        statistics="results/statistics.nc",
    output:
        table="results/tables/closed_loop.csv",
    log:
        "logs/tabulate_closed_loop.log",
    benchmark:
        "results/benchmarks/tabulate_closed_loop/all.tsv"
    resources:
        mem_mb=2000,
    params:
        varies=config["labels"]["recipe"] == "measured",
    message:
        "statistics of renders of all label sets, beside those they were rendered from"
    script:
        "../scripts/tabulate_closed_loop.py"
