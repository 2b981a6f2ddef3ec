# The sample flight (statistics come from it) and the benchmark (train, validation and test scenes).

from snowsim.reference import checked_settings
from snowsim.reference.line import line_length_km


def check_reference(config):
    """Refuse settings of the reference flight that contradict each other, in one line, before any job starts."""
    try:
        checked_settings(config["reference"])
    except ValueError as error:
        raise WorkflowError(
            f"config: reference.{str(error).removeprefix('reference.')}"
        ) from None
    radar, flight = config["reference"]["radar"], config["flight"]
    length_km = (
        flight["n_frames"] * flight["n_range_lines"] * radar["line_spacing_m"] / 1e3
    )
    if length_km > line_length_km():
        raise WorkflowError(
            f"config: flight.n_frames: expected frames that fit on the line of {line_length_km():.0f} km, "
            f"got {flight['n_frames']} of {flight['n_range_lines']} lines, {length_km:.0f} km"
        )


check_reference(config)


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
