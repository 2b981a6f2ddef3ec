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
        **config["statistics"],
    message:
        "flight statistics"
    script:
        str(SCRIPTS / "fit_statistics.py")  # absolute, for rules that are made of this one


N_LAYERS_RANGE = [config["labels"]["n_layers_min"], config["labels"]["n_layers_max"]]
# Of PHY, which a label set records.
CHOICES = ["width", "width_bounds", "n_looks", "speckle_correlation"]
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
        choices={name: config["phy"][name] for name in CHOICES},
    message:
        "label sets, shard {wildcards.shard}"
    script:
        str(SCRIPTS / "draw_labels.py")  # absolute, for rules that are made of this one


rule labels:
    input:
        LABEL_FILES,
    message:
        "all label sets"
