# Renders of the test masks against the observed test scenes: Table II, Figs 10-12.


rule score_similarity:
    input:
        observed="results/benchmark/test/{shard}.nc",
        rendered="results/{method}/test/{shard}.nc",
        code=imported_by("score_similarity.py"),
    output:
        images="results/similarity/{method}/{shard}.parquet",
        rows="results/similarity/{method}/{shard}_rows.parquet",
    log:
        "logs/score_similarity/{method}/{shard}.log",
    benchmark:
        "results/benchmarks/score_similarity/{method}/{shard}.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    message:
        "similarity of {wildcards.method} renders, shard {wildcards.shard}"
    script:
        "../scripts/score_similarity.py"


rule tabulate_similarity:
    input:
        images=expand(
            "results/similarity/{method}/{shard}.parquet",
            method=METHODS,
            shard=shards("test"),
        ),
        rows=expand(
            "results/similarity/{method}/{shard}_rows.parquet",
            method=METHODS,
            shard=shards("test"),
        ),
        code=imported_by("tabulate_similarity.py"),
    output:
        images="results/similarity.parquet",
        table2="results/tables/table2.csv",
        ssim_depth="results/tables/ssim_depth.csv",
    log:
        "logs/tabulate_similarity.log",
    benchmark:
        "results/benchmarks/tabulate_similarity/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        window_rows=config["similarity"]["window_rows"],
    message:
        "Table II"
    script:
        "../scripts/tabulate_similarity.py"


rule explain_similarity:
    input:
        observed=benchmark_files("test"),
        cgan=rendered_files("cgan", "test"),
        phy=rendered_files("phy", "test"),
        train=benchmark_files("train"),
        generator="results/cgan/generator.safetensors",
        statistics="results/statistics.nc",
        code=imported_by("explain_similarity.py"),
    output:
        bounds="results/tables/similarity_bounds.csv",
        parts="results/tables/similarity_parts.csv",
    log:
        "logs/explain_similarity.log",
    benchmark:
        "results/benchmarks/explain_similarity/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=2000,
        gpu=int(config["cgan"]["device"] == "cuda"),
    params:
        seed=config["seed"],
        n_looks=config["benchmark"]["n_looks"],
        statistics=config["cgan"]["statistics"],
        phy=config["phy"],
        validation=config["cgan"]["validation"],
        device=config["cgan"]["device"],
    message:
        "bounds of similarity and what keeps renders from them"
    script:
        "../scripts/explain_similarity.py"


rule measure_air:
    input:
        observed=benchmark_files("test"),
        cgan=rendered_files("cgan", "test"),
        phy=rendered_files("phy", "test"),
        code=imported_by("measure_air.py"),
    output:
        table="results/tables/air_texture.csv",
    log:
        "logs/measure_air.log",
    benchmark:
        "results/benchmarks/measure_air/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    message:
        "texture above the snow surface"
    script:
        "../scripts/measure_air.py"


rule similarity:
    input:
        rules.tabulate_similarity.output,
        *figure_files("similarity"),
        rules.explain_similarity.output,
        rules.measure_air.output,
    message:
        "Table II and its figures"
