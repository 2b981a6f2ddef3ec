# The layer tracker on real data and on three augmented sets, and its edge scores: Table III.


rule train_tracker:
    input:
        real=lambda w: benchmark_files("train") if w.training_set not in ALONE else [],
        phy=lambda w: added_scenes("phy", w.training_set),
        cgan=lambda w: added_scenes("cgan", w.training_set),
        own=lambda w: [
            path for name in OWN_RENDERERS for path in added_scenes(name, w.training_set)
        ],
    output:
        network="results/tracker/{training_set}/{replica}.safetensors",
        losses="results/tracker/{training_set}/{replica}_losses.csv",
    log:
        "logs/train_tracker/{training_set}/{replica}.log",
    benchmark:
        "results/benchmarks/train_tracker/{training_set}/{replica}.tsv"
    priority: 50
    threads: training_threads(TRACKER["device"])
    resources:
        mem_mb=2000,
        gpu=int(TRACKER["device"] == "cuda"),
    params:
        seed=config["seed"],
        replica="{replica}",
        device=TRACKER["device"],
        n_epochs=TRACKER["n_epochs"],
        data={"added_per_real": TRACKER["added_per_real"]},
        settings=TRACKER["training"],
        checkpoint=f"{CHECKPOINTS}/train_tracker_{{training_set}}_{{replica}}.safetensors",
        checkpoint_steps=config["checkpoints"]["every_steps"],
        events=f"{EVENTS}/train_tracker/{{training_set}}/{{replica}}",
    message:
        "tracker on {wildcards.training_set}, replica {wildcards.replica}"
    script:
        str(ROOT / "workflow/scripts/train_tracker.py")


rule score_tracker:
    input:
        scenes=benchmark_files("test"),
        validation=benchmark_files("validation"),
        networks=expand("results/tracker/{{scored_set}}/{replica}.safetensors", replica=SEEDS),
    output:
        counts=expand("results/tracker/{{scored_set}}/{replica}_counts.parquet", replica=SEEDS),
        picks=expand("results/tracker/{{scored_set}}/{replica}_picks.parquet", replica=SEEDS),
        validation=validation_counts("results/tracker/{{scored_set}}/{replica}"),
    log:
        "logs/score_tracker/{scored_set}.log",
    benchmark:
        "results/benchmarks/score_tracker/{scored_set}.tsv"
    resources:
        mem_mb=2000,
        gpu=int(TRACKER["device"] == "cuda"),
    params:
        device=TRACKER["device"],
        # A tracker with the published loss is also scored at the published thresholds.
        as_published=TRACKER["training"]["layer_share"] is None,
    message:
        "edge scores of {wildcards.scored_set}, every replica"
    script:
        str(ROOT / "workflow/scripts/score_tracker.py")


RUNS = [(name, replica) for name in TRAINING_SETS | OWN_SETS for replica in SEEDS]


rule tabulate_trackers:
    input:
        counts=[f"results/tracker/{name}/{replica}_counts.parquet" for name, replica in RUNS],
        picks=[f"results/tracker/{name}/{replica}_picks.parquet" for name, replica in RUNS],
        statistics="results/statistics.nc",
    output:
        table3=report("results/tables/table3.csv", category="tracker"),
        intervals="results/tables/table3_intervals.csv",
        curves="results/tables/precision_recall.csv",
        zones="results/tables/table3_zones.csv",
        pick_errors="results/tables/picks.csv",
        picks_by_zone="results/tables/picks_by_zone.csv",
        picks_by_depth="results/tables/picks_by_depth.csv",
    log:
        "logs/tabulate_trackers.log",
    benchmark:
        "results/benchmarks/tabulate_trackers/all.tsv"
    params:
        **TRACKER["picks"],
        seed=config["seed"],
        n_bootstrap=TRACKER["n_bootstrap"],
        runs=RUNS,
    message:
        "Table III, scores by zone, errors of picks"
    script:
        "../scripts/tabulate_trackers.py"


# Trackers of someone's own, functions of an image.
if OWN_TRACKERS:

    rule score_own:
        input:
            scenes=benchmark_files("test"),
            function=lambda w: OWN_TRACKERS[w.tracker],
        output:
            table="results/tables/own_{tracker}.csv",
        log:
            "logs/score_own/{tracker}.log",
        benchmark:
            "results/benchmarks/score_own/{tracker}.tsv"
        wildcard_constraints:
            tracker="|".join(OWN_TRACKERS),
        params:
            tracker="{tracker}",
            seed=config["seed"],
            n_bootstrap=TRACKER["n_bootstrap"],
        message:
            "edge scores and errors of picks of {wildcards.tracker} on test scenes"
        script:
            "../scripts/score_own.py"


rule trackers:
    input:
        rules.tabulate_trackers.output,
        expand("results/tables/own_{tracker}.csv", tracker=OWN_TRACKERS),
    message:
        "Table III, errors of picks"
