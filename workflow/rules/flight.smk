# The sample flight (statistics come from it) and the benchmark (train, validation and test scenes).


include: "reference_checks.smk"


rule reference_frame:
    input:
        code=package("reference", "io.files"),
    output:
        echogram="results/flight/{frame}.nc",
        layers="results/flight/{frame}_layers.nc",
    log:
        "logs/reference_frame/{frame}.log",
    benchmark:
        "results/benchmarks/reference_frame/{frame}.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        seed=config["seed"],
        flight=config["flight"],
        reference=config["reference"],
    message:
        "frame {wildcards.frame} of the synthetic reference flight"
    script:
        "../scripts/reference_frame.py"


rule reference_segment:
    input:
        code=package("reference", "io.files"),
    output:
        segment="results/flight/segment.nc",
    log:
        "logs/reference_segment.log",
    benchmark:
        "results/benchmarks/reference_segment/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        seed=config["seed"],
        reference=config["reference"],
    message:
        "complex 5 km segment of the synthetic reference flight"
    script:
        "../scripts/reference_segment.py"


rule reference_scenes:
    input:
        code=package("reference", "io.files", "io.scenes"),
    output:
        scenes="results/benchmark/{split}/{shard}.nc",
    log:
        "logs/reference_scenes/{split}/{shard}.log",
    benchmark:
        "results/benchmarks/reference_scenes/{split}/{shard}.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        seed=config["seed"],
        reference=config["reference"],
        n_looks=config["benchmark"]["n_looks"],
        span=lambda wildcards: shard_range(wildcards.split, wildcards.shard),
        source=SYNTHETIC,
    message:
        "{wildcards.split} scenes, shard {wildcards.shard}, of the synthetic benchmark"
    script:
        "../scripts/reference_scenes.py"


rule flight:
    input:
        expand("results/flight/{frame}.nc", frame=FRAMES),
        "results/flight/segment.nc",
        *[benchmark_files(split) for split in SPLITS],
    message:
        "the sample flight and the benchmark"
