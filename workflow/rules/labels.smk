# Sums over the flight -> flight statistics -> synthetic layer sets.

# Sums over a shard of frames or, where there are only images, over a file of train scenes.
SUMMARIES = [
    f"results/statistics/{number}.nc" for number in FRAME_SHARDS or shards("train")
]


rule fit_statistics:
    input:
        summaries=SUMMARIES,
        segment=SEGMENT,
        code=imported_by("fit_statistics.py"),
    output:
        statistics="results/statistics.nc",
    log:
        "logs/fit_statistics.log",
    benchmark:
        "results/benchmarks/fit_statistics/all.tsv"
    resources:
        mem_mb=1500,
    params:
        estimator=config["statistics"]["estimator"],
    message:
        "flight statistics"
    script:
        "../scripts/fit_statistics.py"


N_LAYERS_RANGE = [config["labels"]["n_layers_min"], config["labels"]["n_layers_max"]]
LABEL_FILES = expand("results/labels/{shard}.nc", shard=shards("labels"))


rule draw_labels:
    input:
        statistics="results/statistics.nc",
        code=imported_by("draw_labels.py"),
    output:
        labels="results/labels/{shard}.nc",
    log:
        "logs/draw_labels/{shard}.log",
    benchmark:
        "results/benchmarks/draw_labels/{shard}.tsv"
    resources:
        results_mb=lambda wildcards: scenes_mb("labels", wildcards.shard, 18),
    params:
        seed=config["seed"],
        span=lambda wildcards: shard_range("labels", wildcards.shard),
        n_range_lines=config["labels"]["n_range_lines"],
        n_layers=config["labels"]["n_layers"],
        n_layers_range=N_LAYERS_RANGE,
        first_slab=config["labels"]["first_slab"],
        surface=config["labels"]["surface"],
        correlation=config["labels"]["correlation"],
        radiometry=config["labels"]["radiometry"],
        nonstationary=config["labels"]["nonstationary"],
        choices={
            "width": config["phy"]["width"],
            "width_bounds": config["phy"]["width_bounds"],
            "n_looks": config["phy"]["n_looks"],
            "speckle_correlation": config["phy"]["speckle_correlation"],
        },
    message:
        "label sets, shard {wildcards.shard}"
    script:
        "../scripts/draw_labels.py"


rule summarise_labels:
    input:
        statistics="results/statistics.nc",
        summaries=SUMMARIES,
        labels=LABEL_FILES,
        code=imported_by("summarise_labels.py"),
    output:
        layers="results/tables/label_layers.csv",
        moments="results/tables/label_moments.csv",
        spectra="results/tables/label_spectra.csv",
        correlation="results/tables/label_correlation.csv",
        rule="results/tables/label_rule.csv",
        structure="results/tables/label_structure.csv",
        histograms="results/tables/label_histograms.csv",
    log:
        "logs/summarise_labels.log",
    benchmark:
        "results/benchmarks/summarise_labels/all.tsv"
    resources:
        mem_mb=2000,
    message:
        "what was drawn against what it was drawn from"
    script:
        "../scripts/summarise_labels.py"


rule labels:
    input:
        rules.summarise_labels.input.labels,
        rules.summarise_labels.output,
        tables("model_selection", "model_selection_scenes", "model_selection_spectra"),
        tables("speed_accuracy_labels"),
        figure_files("labels"),
    message:
        "all label sets and their tables"
