# Figures, with one rule for each stage: x.svg is the output x_svg of its rule and has its caption in captions/x.rst.

# The source that figures name, and the snow density that turns range bins into metres.
DRAWING = {
    "source": NOTE,
    "snow_density_kg_m3": config["tracker"]["picks"]["snow_density_kg_m3"],
}
# Figures of frames, which a benchmark of images does not have.
OF_FRAMES = ["echogram.svg", "flight_line.svg"] if FRAMES else []


rule plot_flight:
    input:
        statistics="results/statistics.nc",
        frames=expand("results/flight/{frame}.nc", frame=FRAMES),
        picks=expand("results/flight/{frame}_layers.nc", frame=FRAMES),
    output:
        **drawn("flight", "waveforms.svg", *OF_FRAMES),
    log:
        "logs/plot_flight.log",
    benchmark:
        "results/benchmarks/plot_flight/all.tsv"
    params:
        **DRAWING,
        # Natural Earth, 1:110,000,000, public domain.
        coast=of_checkout("workflow/evaluation/greenland_coast.csv"),
    message:
        "figures of the flight and of its statistics"
    script:
        "../scripts/plot_flight.py"


rule plot_labels:
    input:
        statistics="results/statistics.nc",
        labels=expand("results/labels/{shard}.nc", shard=first_shards(500)),
    output:
        **drawn("labels", "labels.svg"),
    log:
        "logs/plot_labels.log",
    benchmark:
        "results/benchmarks/plot_labels/all.tsv"
    params:
        **DRAWING,
        n_scenes=500,
    message:
        "figure of the label sets"
    script:
        "../scripts/plot_labels.py"


rule plot_renders:
    input:
        statistics="results/statistics.nc",
        observed=benchmark_files("test"),
        cgan_test=rendered_files("cgan", "test"),
        phy_test=rendered_files("phy", "test"),
        cgan_labels=expand("results/cgan/labels/{shard}.nc", shard=first_shards(100)),
        phy_labels=expand("results/phy/labels/{shard}.nc", shard=first_shards(100)),
    output:
        **drawn("renders", "sample.svg"),
    log:
        "logs/plot_renders.log",
    benchmark:
        "results/benchmarks/plot_renders/all.tsv"
    params:
        **DRAWING,
        n_labels=100,
    message:
        "figure of renders"
    script:
        "../scripts/plot_renders.py"


rule plot_similarity:
    input:
        statistics="results/statistics.nc",
        images="results/similarity.csv",
        ssim_depth="results/tables/ssim_depth.csv",
    output:
        **drawn("similarity", "similarity_boxplots.svg", "ssim_depth.svg"),
    log:
        "logs/plot_similarity.log",
    benchmark:
        "results/benchmarks/plot_similarity/all.tsv"
    params:
        **DRAWING,
    message:
        "figures of similarity"
    script:
        "../scripts/plot_similarity.py"


rule plot_tracker:
    input:
        statistics="results/statistics.nc",
        scenes=benchmark_files("test"),
        networks=expand("results/tracker/{name}/0.safetensors", name=TRAINING_SETS),
        picks=expand("results/tracker/{name}/0_picks.csv.gz", name=TRAINING_SETS),
        picks_by_depth="results/tables/picks_by_depth.csv",
        precision_recall="results/tables/precision_recall.csv",
    output:
        **drawn("tracker", "picks.svg", "precision_recall.svg"),
    log:
        "logs/plot_tracker.log",
    benchmark:
        "results/benchmarks/plot_tracker/all.tsv"
    resources:
        mem_mb=2000,
        gpu=int(config["tracker"]["device"] == "cuda"),
    params:
        **DRAWING,
        device=config["tracker"]["device"],
    message:
        "figures of the trackers"
    script:
        "../scripts/plot_tracker.py"
