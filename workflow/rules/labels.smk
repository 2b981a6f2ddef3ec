# Flight statistics -> synthetic layer sets.

# Numbers of zones that criteria choose from; the schema allows no others.
ZONE_COUNTS = [1, 2, 3, 4, 6, 8]
# What labels are drawn from: the flight statistics as they are, or a model with other zones or spectra.
LABEL_STATISTICS = (
    "results/statistics.nc"
    if (config["labels"]["n_zones"], config["labels"]["psd"]) == (4, "tabulated")
    else "results/label_model.nc"
)


rule compare_label_models:
    input:
        summaries=SUMMARIES,
        statistics="results/statistics.nc",
        code=imported_by("compare_label_models.py"),
    output:
        model="results/label_model.nc",
        criteria="results/tables/label_criteria.csv",
        savings="results/tables/label_savings.csv",
        spectra="results/tables/label_families.csv",
        seconds="results/tables/speed_accuracy_labels.csv",
    log:
        "logs/compare_label_models.log",
    benchmark:
        "results/benchmarks/compare_label_models/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        seed=config["seed"],
        n_zones=config["labels"]["n_zones"],
        psd=config["labels"]["psd"],
        zone_counts=ZONE_COUNTS,
        n_range_lines=config["labels"]["n_range_lines"],
        n_scenes=min(300, config["labels"]["n_scenes"]),
    message:
        "label models with fewer parameters, and what they save"
    script:
        "../scripts/compare_label_models.py"


rule draw_labels:
    input:
        statistics=LABEL_STATISTICS,
        code=imported_by("draw_labels.py"),
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
        beyond=config["labels"]["beyond"],
    message:
        "label sets, shard {wildcards.shard}"
    script:
        "../scripts/draw_labels.py"


rule summarise_labels:
    input:
        statistics=LABEL_STATISTICS,
        labels=expand("results/labels/{shard}.nc", shard=shards("labels")),
        code=imported_by("summarise_labels.py"),
    output:
        layers="results/tables/label_layers.csv",
        moments="results/tables/label_moments.csv",
        spectra="results/tables/label_spectra.csv",
        correlation="results/tables/label_correlation.csv",
        rule="results/tables/label_rule.csv",
        histograms="results/tables/label_histograms.csv",
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


rule labels:
    input:
        expand("results/labels/{shard}.nc", shard=shards("labels")),
        rules.summarise_labels.output,
        *figure_files("labels"),
        rules.compare_label_models.output,
    message:
        "all label sets and their tables"
