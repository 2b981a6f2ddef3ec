# The layer tracker on real data and on three augmented sets, and its edge scores: Table III. Each set is trained with its own
# best number of gradients and, for comparison, with the largest of these.

N_GRADIENTS = TRACKER["n_gradients"]
MOST_GRADIENTS = max(N_GRADIENTS[name] for name in TRAINING_SETS)
# Names of the trainings of each set with the most gradients.
EQUAL_SETS = {
    name: name if N_GRADIENTS[name] == MOST_GRADIENTS else f"{name}_equal" for name in TRAINING_SETS
}
SETTINGS = {name: TRACKER["training"] | {"n_steps": n} for name, n in N_GRADIENTS.items()}


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
        settings=lambda w: SETTINGS.get(w.training_set, TRACKER["training"]),
        checkpoint=f"{CHECKPOINTS}/train_tracker_{{training_set}}_{{replica}}.safetensors",
        checkpoint_steps=config["checkpoints"]["every_steps"],
        events=f"{EVENTS}/train_tracker/{{training_set}}/{{replica}}",
    message:
        "tracker on {wildcards.training_set}, replica {wildcards.replica}"
    script:
        str(ROOT / "workflow/scripts/train_tracker.py")


use rule train_tracker as train_equal with:
    output:
        network="results/tracker/{training_set}_equal/{replica}.safetensors",
        losses="results/tracker/{training_set}_equal/{replica}_losses.csv",
    log:
        "logs/train_equal/{training_set}/{replica}.log",
    benchmark:
        "results/benchmarks/train_equal/{training_set}/{replica}.tsv"
    params:
        settings=TRACKER["training"] | {"n_steps": MOST_GRADIENTS},
        checkpoint=f"{CHECKPOINTS}/train_equal_{{training_set}}_{{replica}}.safetensors",
        events=f"{EVENTS}/train_equal/{{training_set}}/{{replica}}",
    message:
        "tracker on {wildcards.training_set} with as many gradients as any, replica {wildcards.replica}"


rule score_tracker:
    input:
        scenes=benchmark_files("test"),
        validation=benchmark_files("validation"),
        networks=expand("results/tracker/{{scored_set}}/{replica}.safetensors", replica=SEEDS),
    output:
        counts=expand("results/tracker/{{scored_set}}/{replica}_counts.csv.gz", replica=SEEDS),
        picks=expand("results/tracker/{{scored_set}}/{replica}_picks.csv.gz", replica=SEEDS),
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
        counts=[f"results/tracker/{name}/{replica}_counts.csv.gz" for name, replica in RUNS],
        picks=[f"results/tracker/{name}/{replica}_picks.csv.gz" for name, replica in RUNS],
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


rule tabulate_equal:
    input:
        counts=[
            f"results/tracker/{name}/{replica}_counts.csv.gz"
            for name in EQUAL_SETS.values()
            for replica in SEEDS
        ],
    output:
        table3="results/tables/table3_equal.csv",
    log:
        "logs/tabulate_equal.log",
    benchmark:
        "results/benchmarks/tabulate_equal/all.tsv"
    params:
        seed=config["seed"],
        n_bootstrap=TRACKER["n_bootstrap"],
        training_sets=list(EQUAL_SETS),
    message:
        "Table III with equal gradients"
    script:
        "../scripts/tabulate_equal.py"


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
            function=lambda w: finished([OWN_TRACKERS[w.tracker]]),
            seed=config["seed"],
            n_bootstrap=TRACKER["n_bootstrap"],
        message:
            "edge scores and errors of picks of {wildcards.tracker} on test scenes"
        script:
            "../scripts/score_own.py"


rule trackers:
    input:
        rules.tabulate_trackers.output,
        # With epochs, numbers of gradients follow from the sets' sizes.
        rules.tabulate_equal.output if TRACKER["n_epochs"] is None else [],
        expand("results/tables/own_{tracker}.csv", tracker=OWN_TRACKERS),
    message:
        "Table III, errors of picks"
