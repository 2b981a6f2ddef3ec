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


rule plot_similarity:
    input:
        images="results/similarity.parquet",
        ssim_depth="results/tables/ssim_depth.csv",
        code=imported_by("plot_similarity.py"),
    output:
        boxplots=report(
            "results/figures/similarity_boxplots.svg",
            caption="../report/similarity_boxplots.rst",
        ),
        ssim_depth=report(
            "results/figures/ssim_depth.svg", caption="../report/ssim_depth.rst"
        ),
    log:
        "logs/plot_similarity.log",
    benchmark:
        "results/benchmarks/plot_similarity/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        source=NOTE,
    message:
        "figures of similarity"
    script:
        "../scripts/plot_similarity.py"


rule plot_sample:
    input:
        observed=benchmark_files("test"),
        cgan=rendered_files("cgan", "test"),
        phy=rendered_files("phy", "test"),
        images="results/similarity.parquet",
        code=imported_by("plot_sample.py"),
    output:
        sample=report("results/figures/sample.svg", caption="../report/sample.rst"),
    log:
        "logs/plot_sample.log",
    benchmark:
        "results/benchmarks/plot_sample/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        source=NOTE,
    message:
        "observed, labels, cGAN, PHY of a few test scenes"
    script:
        "../scripts/plot_sample.py"


rule plot_similarity_bounds:
    input:
        bounds="results/tables/similarity_bounds.csv",
        parts="results/tables/similarity_parts.csv",
        air="results/tables/air_texture.csv",
        code=imported_by("plot_similarity_bounds.py"),
    output:
        figure=report(
            "results/figures/similarity_bounds.svg",
            caption="../report/similarity_bounds.rst",
        ),
    log:
        "logs/plot_similarity_bounds.log",
    benchmark:
        "results/benchmarks/plot_similarity_bounds/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        source=NOTE,
    message:
        "figure of the bounds of similarity"
    script:
        "../scripts/plot_similarity_bounds.py"


rule similarity:
    input:
        rules.tabulate_similarity.output,
        rules.plot_similarity.output,
        rules.plot_sample.output,
        "results/tables/similarity_bounds.csv",
        "results/tables/similarity_parts.csv",
        "results/tables/air_texture.csv",
        rules.plot_similarity_bounds.output,
        rules.plot_cgan_training.output,
    message:
        "Table II and its figures"
