# What judges the run: labels, renders and trackers beside what they were made from.

from evaluation.lib.conventions import Convention


rule summarise_labels:
    input:
        statistics="results/statistics.nc",
        summaries=SUMMARIES,
        labels=LABEL_FILES,
        code=imported_by(EVALUATION / "summarise_labels.py"),
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


rule track_samples:
    input:
        scenes=benchmark_files("test"),
        networks=expand(
            "results/tracker/{training_set}/0.safetensors", training_set=TRAINING_SETS
        ),
        code=imported_by(EVALUATION / "track_samples.py"),
    output:
        samples="results/tracker/samples.nc",
    log:
        "logs/track_samples.log",
    benchmark:
        "results/benchmarks/track_samples/all.tsv"
    resources:
        mem_mb=2000,
        gpu=int(config["tracker"]["device"] == "cuda"),
    params:
        training_sets=list(TRAINING_SETS),
        device=config["tracker"]["device"],
        n_scenes=2,
    message:
        "side outputs on a few test scenes"
    script:
        "../scripts/track_samples.py"


DRAWN_SHARDS = first_shards(config["drawn_scenes"]["n_scenes"])


rule compare_scenes:
    input:
        observed=benchmark_files("train"),
        phy=expand("results/phy/labels/{shard}.nc", shard=DRAWN_SHARDS),
        cgan=expand("results/cgan/labels/{shard}.nc", shard=DRAWN_SHARDS),
        code=imported_by(EVALUATION / "compare_scenes.py"),
    output:
        two_sample="results/tables/two_sample.csv",
        numbers="results/tables/drawn_scenes.csv",
    log:
        "logs/compare_scenes.log",
    benchmark:
        "results/benchmarks/compare_scenes/all.tsv"
    resources:
        mem_mb=2000,
    params:
        n_scenes=config["drawn_scenes"]["n_scenes"],
        n_splits=config["drawn_scenes"]["n_splits"],
        n_steps=config["drawn_scenes"]["n_steps"],
        seed=config["seed"],
    message:
        "drawn scenes beside observed ones: can they be distinguished, and by what"
    script:
        "../scripts/compare_scenes.py"


# Statistics re-estimated from PHY's renders beside those that went into them; decides PHY's conventions.

# One in so many averaged range lines of a scene is kept: six of twelve still follow fading along the scene.
LOOP_STRIDE = 2
# The convention PHY uses goes through all label sets. All conventions are tried on the first scenes.
LOOP_TRIED = min(200, N_SCENES["labels"])
LOOP_SHARDS = first_shards(LOOP_TRIED)
ESTIMATOR = config["statistics"]["estimator"]
LOOP_DEFAULT = Convention(
    estimator=ESTIMATOR,
    normalise=config["phy"]["normalise"],
    align=config["phy"]["align"],
    width=config["phy"]["width"],
)
CONVENTIONS = [
    LOOP_DEFAULT,
    Convention("deblended", normalise="peak", align="peak", width="fitted"),
    Convention("deblended", normalise="none", align="peak", width="fitted"),
    Convention("deblended", normalise="peak", align="gaussian", width="fitted"),
    Convention("deblended", normalise="peak", align="peak", width="paper"),
    # As printed, estimates and all.
    Convention("paper", normalise="none", align="gaussian", width="paper"),
]
TRIED = {convention.name: convention for convention in CONVENTIONS}
# The flight's statistics by every estimator.
STATISTICS = {
    "deblended": "results/closed_loop/flight_deblended.nc",
    "paper": "results/closed_loop/flight_paper.nc",
    ESTIMATOR: "results/statistics.nc",
}


wildcard_constraints:
    estimator="|".join(STATISTICS),
    convention="|".join(TRIED),


rule render_closed_loop:
    input:
        layers="results/labels/{shard}.nc",
        statistics="results/statistics.nc",
        code=imported_by(EVALUATION / "render_closed_loop.py"),
    output:
        summary=temp("results/closed_loop/parts/{shard}.nc"),
    log:
        "logs/render_closed_loop/{shard}.log",
    benchmark:
        "results/benchmarks/render_closed_loop/{shard}.tsv"
    params:
        convention=vars(LOOP_DEFAULT),
        seed=config["seed"],
        phy=config["phy"],
        first=lambda wildcards: shard_range("labels", wildcards.shard)[0],
        stride=LOOP_STRIDE,
    message:
        "sums over renders, shard {wildcards.shard}"
    script:
        "../scripts/render_closed_loop.py"


rule tabulate_closed_loop:
    input:
        summaries=expand("results/closed_loop/parts/{shard}.nc", shard=shards("labels")),
        statistics="results/statistics.nc",
        tried_tables=expand(rules.try_convention.output.table, convention=TRIED),
        tried_statistics=expand(rules.try_convention.output.recovered, convention=TRIED),
        code=imported_by(EVALUATION / "tabulate_closed_loop.py"),
    output:
        recovered=f"results/closed_loop/{LOOP_DEFAULT.name}_all.nc",
        errors=f"results/closed_loop/{LOOP_DEFAULT.name}_all.csv",
        table="results/tables/closed_loop.csv",
        summary="results/tables/closed_loop_summary.csv",
        conventions="results/tables/closed_loop_conventions.csv",
    log:
        "logs/tabulate_closed_loop.log",
    benchmark:
        "results/benchmarks/tabulate_closed_loop/all.tsv"
    resources:
        mem_mb=2000,
    params:
        tried=[vars(convention) for convention in TRIED.values()],
        varies=config["labels"]["radiometry"] == "measured",
    message:
        "statistics of renders of all label sets, tables of the closed loop"
    script:
        "../scripts/tabulate_closed_loop.py"


rule closed_loop:
    input:
        rules.tabulate_closed_loop.output.table,
        rules.tabulate_closed_loop.output.summary,
        rules.tabulate_closed_loop.output.conventions,
        rules.plot_closed_loop.output,
    message:
        "statistics that went into PHY beside those re-estimated from its renders"


# Layers that the tracker of the package picks in real pictures of one place in two years. Not part of the default run.


# Accuracy of the convolution model: against a coherent solver with all multiples, and against off-nadir integrals.


