# The layer tracker on real data and on three augmented sets, and its edge scores: Table III.


rule train_tracker:
    input:
        real=real_scenes,
        phy=added_scenes("phy"),
        cgan=added_scenes("cgan"),
        code=imported_by("train_tracker.py"),
    output:
        network="results/tracker/{training_set}/{replica}.safetensors",
        losses="results/tracker/{training_set}/{replica}_losses.csv",
    log:
        "logs/train_tracker/{training_set}/{replica}.log",
    benchmark:
        "results/benchmarks/train_tracker/{training_set}/{replica}.tsv"
    priority: 50
    resources:
        mem_mb=2000,
        gpu=int(config["tracker"]["device"] == "cuda"),
    params:
        seed=config["seed"],
        replica="{replica}",
        device=config["tracker"]["device"],
        n_epochs=config["tracker"]["n_epochs"],
        data={
            "added_per_real": config["tracker"]["added_per_real"],
            "order": config["tracker"]["order"],
        },
        settings=config["tracker"]["training"],
        skip=0,
        checkpoint=f"{CHECKPOINTS}/train_tracker_{{training_set}}_{{replica}}.safetensors",
        checkpoint_steps=config["checkpoints"]["every_steps"],
        events=f"{EVENTS}/train_tracker/{{training_set}}/{{replica}}",
    message:
        "tracker on {wildcards.training_set}, replica {wildcards.replica}"
    script:
        str(SCRIPTS / "train_tracker.py")  # absolute, for rules that are made of this one


rule score_tracker:
    input:
        scenes=benchmark_files("test"),
        networks=expand(
            "results/tracker/{{training_set}}/{replica}.safetensors", replica=SEEDS
        ),
        code=imported_by("score_tracker.py"),
    output:
        counts=expand(
            "results/tracker/{{training_set}}/{replica}_counts.parquet", replica=SEEDS
        ),
        picks=expand(
            "results/tracker/{{training_set}}/{replica}_picks.parquet", replica=SEEDS
        ),
    log:
        "logs/score_tracker/{training_set}.log",
    benchmark:
        "results/benchmarks/score_tracker/{training_set}.tsv"
    resources:
        mem_mb=2000,
        gpu=int(config["tracker"]["device"] == "cuda"),
    params:
        device=config["tracker"]["device"],
    message:
        "edge scores of {wildcards.training_set}, every replica"
    script:
        str(SCRIPTS / "score_tracker.py")  # absolute, for rules that are made of this one


rule tabulate_trackers:
    input:
        counts=expand(
            "results/tracker/{training_set}/{replica}_counts.parquet",
            training_set=TRAINING_SETS,
            replica=SEEDS,
        ),
        picks=expand(
            "results/tracker/{training_set}/{replica}_picks.parquet",
            training_set=TRAINING_SETS,
            replica=SEEDS,
        ),
        statistics="results/statistics.nc",
        code=imported_by("tabulate_trackers.py"),
    output:
        table3=report("results/tables/table3.csv", category="tracker"),
        intervals="results/tables/table3_intervals.csv",
        tests="results/tables/table3_tests.csv",
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
        seed=config["seed"],
        n_bootstrap=config["tracker"]["n_bootstrap"],
        runs=[(name, replica) for name in TRAINING_SETS for replica in SEEDS],
        depth_step_bins=config["tracker"]["picks"]["depth_step_bins"],
        snow_density_kg_m3=config["tracker"]["picks"]["snow_density_kg_m3"],
    message:
        "Table III, scores by zone, errors of picks"
    script:
        "../scripts/tabulate_trackers.py"


rule trackers:
    input:
        rules.tabulate_trackers.output,
    message:
        "Table III, errors of picks"
