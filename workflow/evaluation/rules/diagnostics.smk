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


rule compare_label_models:
    input:
        summaries=SUMMARIES,
        statistics="results/statistics.nc",
        code=imported_by(EVALUATION / "compare_label_models.py"),
    output:
        selection="results/tables/model_selection.csv",
        scenes="results/tables/model_selection_scenes.csv",
        spectra="results/tables/model_selection_spectra.csv",
        seconds="results/tables/speed_accuracy_labels.csv",
    log:
        "logs/compare_label_models.log",
    benchmark:
        "results/benchmarks/compare_label_models/all.tsv"
    resources:
        mem_mb=1500,
    params:
        seed=config["seed"],
        zone_counts=[1, 2, 3, 4, 6, 8],
        n_range_lines=config["labels"]["n_range_lines"],
        n_scenes=min(300, config["labels"]["n_scenes"]),
    message:
        "model selection: label models with fewer parameters"
    script:
        "../scripts/compare_label_models.py"


rule label_models:
    input:
        rules.summarise_labels.output,
        rules.compare_label_models.output,
        rules.plot_labels.output,
    message:
        "label sets beside the flight, and label models with fewer parameters"


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


rule compare_renders:
    input:
        observed=benchmark_files("test"),
        cgan=rendered_files("cgan", "test"),
        phy=rendered_files("phy", "test"),
        train=benchmark_files("train"),
        generator="results/cgan/generator.safetensors",
        statistics="results/statistics.nc",
        code=imported_by(EVALUATION / "compare_renders.py"),
    output:
        positions="results/tables/render_positions.csv",
        textures="results/tables/render_texture.csv",
        air="results/tables/air_texture.csv",
        bounds="results/tables/similarity_bounds.csv",
        parts="results/tables/similarity_parts.csv",
    log:
        "logs/compare_renders.log",
    benchmark:
        "results/benchmarks/compare_renders/all.tsv"
    resources:
        mem_mb=2000,
        gpu=int(config["cgan"]["device"] == "cuda"),
    params:
        seed=config["seed"],
        n_looks=config["benchmark"]["n_looks"],
        conventions=config["phy"],
        n_held=config["cgan"]["validation"]["n_scenes"],
        device=config["cgan"]["device"],
    message:
        "layers and texture in renders of test masks, what bounds their similarity"
    script:
        "../scripts/compare_renders.py"


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


rule claims:
    input:
        rules.compare_renders.output,
        rules.compare_scenes.output,
        rules.plot_similarity.output,
    message:
        "tables behind what the paper claims of renders"


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


use rule fit_statistics as fit_other_statistics with:
    output:
        statistics="results/closed_loop/flight_{estimator}.nc",
    log:
        "logs/fit_other_statistics/{estimator}.log",
    benchmark:
        "results/benchmarks/fit_other_statistics/{estimator}.tsv"
    params:
        estimator="{estimator}",
    message:
        "flight statistics by the estimator {wildcards.estimator}"


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


rule try_convention:
    input:
        layers=expand("results/labels/{shard}.nc", shard=LOOP_SHARDS),
        statistics=lambda w: STATISTICS[TRIED[w.convention].estimator],
        code=imported_by(EVALUATION / "try_convention.py"),
    output:
        recovered="results/closed_loop/{convention}_first.nc",
        table="results/closed_loop/{convention}_first.csv",
    log:
        "logs/try_convention/{convention}.log",
    benchmark:
        "results/benchmarks/try_convention/{convention}.tsv"
    params:
        convention=lambda w: vars(TRIED[w.convention]),
        seed=config["seed"],
        phy=config["phy"],
        n_scenes=LOOP_TRIED,
        stride=3 * LOOP_STRIDE,  # of shapes, which do not fade
        varies=config["labels"]["radiometry"] == "measured",
    message:
        "statistics of renders by {wildcards.convention}"
    script:
        "../scripts/try_convention.py"


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


rule tabulate_validation:
    input:
        summaries=SUMMARIES,
        statistics="results/statistics.nc",
        rendered=rules.tabulate_closed_loop.output.recovered,
        label_layers="results/tables/label_layers.csv",
        label_histograms="results/tables/label_histograms.csv",
        code=imported_by(EVALUATION / "tabulate_validation.py"),
    output:
        thickness="results/tables/validation_thickness.csv",
        tests="results/tables/validation_tests.csv",
        distributions="results/tables/validation_distributions.csv",
        superposition="results/tables/superposition.csv",
        tracked_power="results/tables/tracked_power.csv",
        independence="results/tables/independence.csv",
    log:
        "logs/tabulate_validation.log",
    benchmark:
        "results/benchmarks/tabulate_validation/all.tsv"
    resources:
        mem_mb=1500,
    params:
        seed=config["seed"],
    message:
        "distributions of the flight beside labels, renders and laws"
    script:
        "../scripts/tabulate_validation.py"


rule validation:
    input:
        rules.tabulate_validation.output,
        rules.plot_closed_loop.output,
    message:
        "the flight beside what was made of its statistics"


rule tabulate_realism:
    input:
        echograms=flight_files("results/flight/{frame}.nc"),
        layers=flight_files("results/flight/{frame}_layers.nc"),
        statistics="results/statistics.nc",
        train=benchmark_files("train"),
        test=benchmark_files("test"),
        record=str(ROOT / "workflow/evaluation/lib/real_snow_radar.csv"),
        rows=str(ROOT / "workflow/evaluation/lib/realism_rows.yaml"),
        unread=REAL_FILES,
        code=imported_by(EVALUATION / "tabulate_realism.py"),
    output:
        **({"crops": "results/realism_crops.nc"} if REAL else {}),
        table="results/tables/realism.csv",
        real="results/tables/real_snow_radar.csv",
    log:
        "logs/tabulate_realism.log",
    benchmark:
        "results/benchmarks/tabulate_realism/all.tsv"
    params:
        folder=REAL,
        reference=config["reference"],
        source=NOTE,
        seed=config["seed"],
    message:
        "flight and benchmark beside real Snow Radar"
    script:
        "../scripts/tabulate_realism.py"


rule realism:
    input:
        rules.tabulate_realism.output,
        rules.plot_realism.output,
        rules.plot_crops.output if REAL else [],
    message:
        "how real the flight and the benchmark look"


# Layers that the tracker of the package picks in real pictures of one place in two years. Not part of the default run.


rule match_repeat_pass:
    input:
        unread=repeat_pass_files,
        code=imported_by(EVALUATION / "match_repeat_pass.py"),
    output:
        picks="results/repeat_pass.nc",
        table="results/tables/repeat_pass.csv",
    log:
        "logs/match_repeat_pass.log",
    benchmark:
        "results/benchmarks/match_repeat_pass/all.tsv"
    params:
        folder=REAL,
        # Of this run, if it has trained a tracker, else as it comes with the package.
        weights=finished(["results/shipped/universal.onnx"])
        or finished([str(ROOT / "snowsim/data/universal.onnx")]),
        n_draws=1000,
        seed=config["seed"],
    message:
        "layers of real pictures that are found in both years"
    script:
        "../scripts/match_repeat_pass.py"


rule repeat_pass:
    input:
        rules.match_repeat_pass.output,
        rules.plot_repeat_pass.output,
    message:
        "the tracker that comes with the package on real pictures of one place in two years"


rule measure_phy:
    input:
        rendered=rendered_files("phy", "labels"),
        code=imported_by(EVALUATION / "measure_phy.py"),
    output:
        waveforms="results/tables/speed_accuracy_waveforms.csv",
        speckle="results/tables/speed_accuracy_speckle.csv",
        scenes="results/tables/speed_accuracy_scenes.csv",
        growth="results/tables/speed_accuracy_growth.csv",
        plans="results/phy_plans.parquet",
        plan="results/tables/phy_plan.csv",
    log:
        "logs/measure_phy.log",
    benchmark:
        "results/benchmarks/measure_phy/all.tsv"
    resources:
        mem_mb=2000,
    params:
        # Planted layers, the same for all charts.
        n_layers=15,
        n_range_lines=256,
        n_range_bins=256,
        n_rounds=5,
        seed=config["seed"],
        reference=config["reference"],
        n_looks=config["benchmark"]["n_looks"],
        cgan=CGAN_SETTINGS,
    message:
        "speed and accuracy of PHY's parts and of whole scenes, and what plans left out"
    script:
        "../scripts/measure_phy.py"


# Where PHY's methods and the estimators of flight statistics fail, and that public functions do not.


rule draw_atlases:
    input:
        code=imported_by(EVALUATION / "draw_atlases.py"),
    output:
        phy="results/tables/atlas_phy.csv",
        phy_regions="results/tables/atlas_phy_regions.csv",
        statistics="results/tables/atlas_statistics.csv",
    log:
        "logs/draw_atlases.log",
    benchmark:
        "results/benchmarks/draw_atlases/all.tsv"
    resources:
        mem_mb=1500,
    params:
        seed=config["seed"],
        # Under half a minute; a flight of test size gets the ends of every sweep alone.
        share=0.7 if config["flight"]["n_frames"] >= 10 else 0.2,
    message:
        "atlases of PHY and of the estimators"
    script:
        "../scripts/draw_atlases.py"


rule atlases:
    input:
        rules.draw_atlases.output,
        rules.plot_atlas.output,
    message:
        "atlases of PHY and of the estimators, with their figures"


rule charts_phy:
    input:
        rules.measure_phy.output,
        rules.atlases.input,
        rules.plot_phy.output,
    message:
        "speed-accuracy charts and atlas of PHY"


# Accuracy of the convolution model: against a coherent solver with all multiples, and against off-nadir integrals.


rule measure_convolution:
    input:
        code=imported_by(EVALUATION / "measure_convolution.py"),
    output:
        table="results/tables/convolution_accuracy.csv",
    log:
        "logs/measure_convolution.log",
    benchmark:
        "results/benchmarks/measure_convolution/all.tsv"
    params:
        reference=config["reference"],
        n_looks=config["benchmark"]["n_looks"],
        seed=config["seed"],
        source=NOTE,
    message:
        "errors and cost of the convolution model"
    script:
        "../scripts/measure_convolution.py"


rule convolution:
    input:
        rules.measure_convolution.output,
        rules.plot_convolution.output,
    message:
        "how good the convolution model is, and where it stops being good enough"
