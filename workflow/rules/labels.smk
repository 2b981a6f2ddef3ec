# Flight statistics -> synthetic layer sets.


rule draw_labels:
    input:
        statistics="results/statistics.nc",
        code=package("labels", "io.files", "io.scenes"),
    output:
        labels="results/labels/{shard}.nc",
    log:
        "logs/draw_labels/{shard}.log",
    benchmark:
        "results/benchmarks/draw_labels/{shard}.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        seed=config["seed"],
        span=lambda wildcards: shard_range("labels", wildcards.shard),
        n_range_lines=config["labels"]["n_range_lines"],
        n_layers=[config["labels"]["n_layers_min"], config["labels"]["n_layers_max"]],
        correlation=config["labels"]["correlation"],
    message:
        "label sets, shard {wildcards.shard}"
    script:
        "../scripts/draw_labels.py"


rule summarise_labels:
    input:
        statistics="results/statistics.nc",
        labels=expand("results/labels/{shard}.nc", shard=shards("labels")),
        code=package("labels", "io.files", "io.scenes"),
    output:
        layers="results/tables/label_layers.csv",
        moments="results/tables/label_moments.csv",
        spectra="results/tables/label_spectra.csv",
        correlation="results/tables/label_correlation.csv",
        rule="results/tables/label_rule.csv",
    log:
        "logs/summarise_labels.log",
    benchmark:
        "results/benchmarks/summarise_labels/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=2000,
    message:
        "what was drawn against what it was drawn from"
    script:
        "../scripts/summarise_labels.py"


rule plot_labels:
    input:
        layers="results/tables/label_layers.csv",
        moments="results/tables/label_moments.csv",
        spectra="results/tables/label_spectra.csv",
        correlation="results/tables/label_correlation.csv",
        code=package("plotting", "io.figures", "io.files"),
    output:
        figure=report("results/figures/labels.svg", caption="../report/labels.rst"),
    log:
        "logs/plot_labels.log",
    benchmark:
        "results/benchmarks/plot_labels/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        source=NOTE,
    message:
        "figure of the label sets"
    script:
        "../scripts/plot_labels.py"


rule labels:
    input:
        expand("results/labels/{shard}.nc", shard=shards("labels")),
        rules.summarise_labels.output,
        rules.plot_labels.output,
    message:
        "all label sets and their tables"
