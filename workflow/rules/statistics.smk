# Observed frames -> flight statistics, one pass, one frame in memory.


rule summarise_frame:
    input:
        echogram="results/flight/{frame}.nc",
        layers="results/flight/{frame}_layers.nc",
        code=package("statistics", "phy.waveform", "io.files"),
    output:
        summary="results/statistics/{frame}.nc",
    log:
        "logs/summarise_frame/{frame}.log",
    benchmark:
        "results/benchmarks/summarise_frame/{frame}.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    message:
        "sums over frame {wildcards.frame}"
    script:
        "../scripts/summarise_frame.py"


rule fit_statistics:
    input:
        summaries=expand("results/statistics/{frame}.nc", frame=FRAMES),
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
