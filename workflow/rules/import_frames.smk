# Own frames (IRSNO1B, CReSIS L1B, Open Polar Radar) as the flight and, cut into blocks, as the benchmark.

READING = {
    "source": SOURCE,
    **{key: OWN[key] for key in ("bin_s", "flattening", "layer_names", "unfit_flags")},
}


def own_frame(role, number):
    """Row of the table: the frame of a role with a number."""
    return OWN_FRAMES[role][int(number)]


def supplement(row):
    """File of quality flags beside an echogram of a row, if any: what it flags is left out."""
    from snowsim.io.nsidc import find_supplement

    found = find_supplement(row["echogram"]) if SOURCE == "nsidc" else None
    return [] if found is None else [str(found)]


rule check_frames:
    input:
        table=OWN["frames"],
        files=sorted(
            {
                file
                for rows in OWN_FRAMES.values()
                for row in rows
                for file in (row["echogram"], row["layers"], *supplement(row))
            }
        ),
        code=imported_by("check_frames.py"),
    output:
        table="results/tables/frames.csv",
    log:
        "logs/check_frames.log",
    benchmark:
        "results/benchmarks/check_frames/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=4000,
    params:
        reading=READING,
    message:
        "check of all frames"
    script:
        "../scripts/check_frames.py"


rule import_frame:
    input:
        echogram=lambda wildcards: own_frame("statistics", wildcards.frame)["echogram"],
        layers=lambda wildcards: own_frame("statistics", wildcards.frame)["layers"],
        supplement=lambda wildcards: supplement(
            own_frame("statistics", wildcards.frame)
        ),
        # Not `ancient`: while the check has to run, Snakemake asks no rule behind it whether its own settings or files
        # have changed, and what was imported with the old ones would stay.
        checked="results/tables/frames.csv",
        code=imported_by("import_frame.py"),
    output:
        echogram="results/flight/{frame}.nc",
        layers="results/flight/{frame}_layers.nc",
    log:
        "logs/import_frame/{frame}.log",
    benchmark:
        "results/benchmarks/import_frame/{frame}.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=4000,
    params:
        name=lambda wildcards: own_frame("statistics", wildcards.frame)["frame"],
        reading=READING,
    message:
        "frame {params.name} of the flight"
    script:
        "../scripts/import_frame.py"


rule import_blocks:
    input:
        echogram=lambda wildcards: own_frame(wildcards.split, wildcards.shard)[
            "echogram"
        ],
        layers=lambda wildcards: own_frame(wildcards.split, wildcards.shard)["layers"],
        supplement=lambda wildcards: supplement(
            own_frame(wildcards.split, wildcards.shard)
        ),
        checked="results/tables/frames.csv",
        code=imported_by("import_blocks.py"),
    output:
        scenes="results/benchmark/{split}/{shard}.nc",
    log:
        "logs/import_blocks/{split}/{shard}.log",
    benchmark:
        "results/benchmarks/import_blocks/{split}/{shard}.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=4000,
    params:
        name=lambda wildcards: own_frame(wildcards.split, wildcards.shard)["frame"],
        reading=READING,
    message:
        "{wildcards.split} scenes of frame {params.name}"
    script:
        "../scripts/import_blocks.py"


rule flight:
    input:
        "results/tables/frames.csv",
        expand("results/flight/{frame}.nc", frame=FRAMES),
        *[benchmark_files(split) for split in SPLITS],
    message:
        "the flight and the benchmark from own frames"
