# What judges the renders of label sets: can they be told from observed scenes, and do they give back the statistics?

DRAWN_SHARDS = first_shards(config["drawn_scenes"]["n_scenes"])


rule compare_scenes:
    input:
        observed=benchmark_files("train"),
        phy=expand("results/phy/labels/{shard}.nc", shard=DRAWN_SHARDS),
        cgan=expand("results/cgan/labels/{shard}.nc", shard=DRAWN_SHARDS),
    output:
        two_sample="results/tables/two_sample.csv",
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
        "drawn scenes beside observed ones: can they be distinguished"
    script:
        "../scripts/compare_scenes.py"


rule render_closed_loop:
    input:
        layers="results/labels/{shard}.nc",
        statistics="results/statistics.nc",
    output:
        summary=temp("results/closed_loop/{shard}.nc"),
    log:
        "logs/render_closed_loop/{shard}.log",
    benchmark:
        "results/benchmarks/render_closed_loop/{shard}.tsv"
    params:
        seed=config["seed"],
        phy=config["phy"],
        first=lambda wildcards: shard_range("labels", wildcards.shard)[0],
    message:
        "sums over renders, shard {wildcards.shard}"
    script:
        "../scripts/render_closed_loop.py"


rule tabulate_closed_loop:
    input:
        summaries=expand("results/closed_loop/{shard}.nc", shard=shards("labels")),
        statistics="results/statistics.nc",
    output:
        table="results/tables/closed_loop.csv",
    log:
        "logs/tabulate_closed_loop.log",
    benchmark:
        "results/benchmarks/tabulate_closed_loop/all.tsv"
    resources:
        mem_mb=2000,
    params:
        varies=config["labels"]["radiometry"] == "measured",
    message:
        "statistics of renders of all label sets, beside those they were rendered from"
    script:
        "../scripts/tabulate_closed_loop.py"


rule closed_loop:
    input:
        rules.tabulate_closed_loop.output.table,
        rules.plot_closed_loop.output,
    message:
        "statistics that went into PHY beside those re-estimated from its renders"


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
