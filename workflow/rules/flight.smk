# The sample flight (statistics come from it) and the benchmark (train, validation and test scenes).


include: "reference_checks.smk"


# A rule for each lot: a job draws several frames, for to start it takes longer than to draw one.
for lot, frames in FRAME_LOTS.items():

    rule:
        name:
            f"reference_frames_{lot}"
        input:
            code=imported_by("reference_frames.py"),
        output:
            echograms=expand("results/flight/{frame}.nc", frame=frames),
            layers=expand("results/flight/{frame}_layers.nc", frame=frames),
        log:
            f"logs/reference_frames/{lot}.log",
        benchmark:
            f"results/benchmarks/reference_frames/{lot}.tsv"
        conda:
            "../../envs/cpu.yaml"
        threads: 1
        resources:
            mem_mb=1500,
        params:
            frames=[int(frame) for frame in frames],
            seed=config["seed"],
            flight={key: config["flight"][key] for key in ("n_frames", "n_range_lines")},
            reference=config["reference"],
        message:
            f"frames of the synthetic reference flight, lot {lot}"
        script:
            "../scripts/reference_frames.py"


rule reference_segment:
    input:
        code=imported_by("reference_segment.py"),
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
        code=imported_by("reference_scenes.py"),
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
