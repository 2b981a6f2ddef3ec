# A folder in the published benchmark's layout as the benchmark; the statistics come from its train scenes.


rule check_pairs:
    input:
        files=[file for scenes in PAIRS.values() for file in scenes.files(slice(None))],
        lists=[
            Path(OWN["pairs"]["folder"]) / OWN["pairs"]["lists"][split]
            for split in PAIRS
        ],
        code=imported_by("check_pairs.py"),
    output:
        table="results/tables/scenes.csv",
    log:
        "logs/check_pairs.log",
    benchmark:
        "results/benchmarks/check_pairs/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        lists={
            split: str(Path(OWN["pairs"]["folder"]) / OWN["pairs"]["lists"][split])
            for split in PAIRS
        },
        data_scale=OWN["pairs"]["data_scale"],
        contrast_db=OWN["pairs"]["contrast_db"],
    message:
        "check of all scenes"
    script:
        "../scripts/check_pairs.py"


rule import_pairs:
    input:
        files=lambda wildcards: PAIRS[wildcards.split].files(
            slice(*shard_range(wildcards.split, wildcards.shard))
        ),
        listing=lambda wildcards: Path(OWN["pairs"]["folder"])
        / OWN["pairs"]["lists"][wildcards.split],
        # Not `ancient`, as for frames: Snakemake would read with a changed setting one run late.
        checked="results/tables/scenes.csv",
        code=imported_by("import_pairs.py"),
    output:
        scenes="results/benchmark/{split}/{shard}.nc",
    log:
        "logs/import_pairs/{split}/{shard}.log",
    benchmark:
        "results/benchmarks/import_pairs/{split}/{shard}.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        span=lambda wildcards: shard_range(wildcards.split, wildcards.shard),
        data_scale=OWN["pairs"]["data_scale"],
    message:
        "{wildcards.split} scenes, shard {wildcards.shard}"
    script:
        "../scripts/import_pairs.py"


rule summarise_scenes:
    input:
        scenes="results/benchmark/train/{shard}.nc",
        code=imported_by("summarise_scenes.py"),
    output:
        summary="results/statistics/{shard}.nc",
    log:
        "logs/summarise_scenes/{shard}.log",
    benchmark:
        "results/benchmarks/summarise_scenes/{shard}.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        bin_s=OWN["bin_s"],
        line_spacing_m=OWN["pairs"]["line_spacing_m"],
        contrast_db=OWN["pairs"]["contrast_db"],
    message:
        "sums over train scenes, shard {wildcards.shard}"
    script:
        "../scripts/summarise_scenes.py"


rule flight:
    input:
        "results/tables/scenes.csv",
        *[benchmark_files(split) for split in SPLITS],
    message:
        "the benchmark from own images"
