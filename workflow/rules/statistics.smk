# Sums over the observed frames -> flight statistics.


# Sums over a lot of frames or, where there are only images, over a file of train scenes.
SUMMARIES = [
    f"results/statistics/{number}.nc" for number in FRAME_LOTS or shards("train")
]


rule fit_statistics:
    input:
        summaries=SUMMARIES,
        segment=SEGMENT,
        code=package("statistics", "phy.waveform", "io.files"),
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
