# Observed frames -> what the statistics need of them, one frame in memory.


rule summarise_frames:
    input:
        echograms=lambda wildcards: expand(
            "results/flight/{frame}.nc", frame=FRAME_LOTS[wildcards.lot]
        ),
        layers=lambda wildcards: expand(
            "results/flight/{frame}_layers.nc", frame=FRAME_LOTS[wildcards.lot]
        ),
        code=package("statistics", "phy.waveform", "io.files"),
    output:
        summary="results/statistics/{lot}.nc",
    log:
        "logs/summarise_frames/{lot}.log",
    benchmark:
        "results/benchmarks/summarise_frames/{lot}.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    message:
        "sums over frames, lot {wildcards.lot}"
    script:
        "../scripts/summarise_frames.py"
