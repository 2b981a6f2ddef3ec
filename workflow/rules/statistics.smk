# Observed frames -> flight statistics, one pass, one frame in memory.


# Sums over a lot of frames or, where there are only images, over a file of train scenes.
SUMMARIES = [
    f"results/statistics/{number}.nc" for number in FRAME_LOTS or shards("train")
]


if FRAME_LOTS:

    rule summarise_frames:
        input:
            echograms=lambda wildcards: expand(
                "results/flight/{frame}.nc", frame=FRAME_LOTS[wildcards.lot]
            ),
            layers=lambda wildcards: expand(
                "results/flight/{frame}_layers.nc", frame=FRAME_LOTS[wildcards.lot]
            ),
            code=imported_by("summarise_frames.py"),
        output:
            summary="results/statistics/{lot}.nc",
        log:
            "logs/summarise_frames/{lot}.log",
        benchmark:
            "results/benchmarks/summarise_frames/{lot}.tsv"
        wildcard_constraints:
            lot="|".join(FRAME_LOTS),
        conda:
            "../../envs/cpu.yaml"
        threads: 1
        resources:
            mem_mb=1000,
        message:
            "sums over frames, lot {wildcards.lot}"
        script:
            "../scripts/summarise_frames.py"


rule fit_statistics:
    input:
        summaries=SUMMARIES,
        segment=SEGMENT,
        code=imported_by("fit_statistics.py"),
    output:
        statistics="results/statistics.nc",
    log:
        "logs/fit_statistics.log",
    benchmark:
        "results/benchmarks/fit_statistics/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        estimator=config["statistics"]["estimator"],
    message:
        "flight statistics"
    script:
        "../scripts/fit_statistics.py"
