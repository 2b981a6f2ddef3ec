# What makes synthetic data help or hurt the tracker, and what the default number of trainings can resolve. Not part of
# the default run: snakemake study_tracker. Settings are compared on the held-out validation scenes; of those that leave
# labels, steps and PHY as they are, the best is scored on the test scenes, once.


include: "runs_of_study_tracker.smk"


use rule render_phy as render_study_phy with:
    input:
        layers="results/labels/{shard}.nc",
        statistics=study_statistics,
        code=imported_by("render_phy.py"),
    output:
        scenes="results/studies/tracker/{setting}/phy/{shard}.nc",
    log:
        "logs/render_study_phy/{setting}/{shard}.log",
    benchmark:
        "results/benchmarks/render_study_phy/{setting}/{shard}.tsv"
    params:
        seed=config["seed"],
        phy=lambda wildcards: {
            **config["phy"],
            **{
                key: value
                for key, value in STUDIED[wildcards.setting]["phy"].items()
                if key != "estimator"
            },
        },
    message:
        "PHY renders of {wildcards.setting}, shard {wildcards.shard}"


use rule train_tracker as train_study_tracker with:
    input:
        real=benchmark_files("train"),
        phy=study_added_scenes("phy"),
        cgan=study_added_scenes("cgan"),
        code=imported_by("train_tracker.py"),
    output:
        network="results/studies/tracker/{setting}/{training_set}/{replica}.safetensors",
        losses="results/studies/tracker/{setting}/{training_set}/{replica}_losses.csv",
    log:
        "logs/train_study_tracker/{setting}/{training_set}/{replica}.log",
    benchmark:
        "results/benchmarks/train_study_tracker/{setting}/{training_set}/{replica}.tsv"
    params:
        seed=config["seed"],
        device=config["tracker"]["device"],
        n_epochs=study_epochs,
        data=study_data,
        settings=study_settings,
        checkpoint=lambda wildcards: "results/checkpoints/train_study_tracker_"
        f"{wildcards.setting}_{wildcards.training_set}_{wildcards.replica}.safetensors",
        checkpoint_steps=config["checkpoints"]["every_steps"],
        events=None,
    message:
        "tracker on {wildcards.training_set}, {wildcards.setting}, replica {wildcards.replica}"


use rule score_tracker as score_study_tracker with:
    input:
        scenes=lambda wildcards: benchmark_files(wildcards.split),
        networks=lambda wildcards: [
            study_network(
                wildcards.any_setting, wildcards.training_set, wildcards.replica
            )
        ],
        code=imported_by("score_tracker.py"),
    output:
        counts=[
            "results/studies/tracker/{any_setting}/{training_set}/{replica}_{split}.parquet"
        ],
    log:
        "logs/score_study_tracker/{any_setting}/{training_set}/{replica}_{split}.log",
    benchmark:
        "results/benchmarks/score_study_tracker/{any_setting}/{training_set}/{replica}_{split}.tsv"
    params:
        device=config["tracker"]["device"],
        outputs=["fuse"],
    message:
        "fused edge scores of {wildcards.training_set}, {wildcards.any_setting}, replica {wildcards.replica}"


if MORE_SEEDS:

    use rule score_tracker as score_more_trackers with:
        input:
            scenes=benchmark_files("test"),
            networks=expand(
                "results/tracker/{{training_set}}/{replica}.safetensors",
                replica=MORE_SEEDS,
            ),
            code=imported_by("score_tracker.py"),
        output:
            counts=expand(
                "results/tracker/{{training_set}}/{replica}_counts.parquet",
                replica=MORE_SEEDS,
            ),
        log:
            "logs/score_more_trackers/{training_set}.log",
        benchmark:
            "results/benchmarks/score_more_trackers/{training_set}.tsv"
        message:
            "edge scores of {wildcards.training_set}, replicas of the study alone"


checkpoint tabulate_ablation:
    input:
        counts=study_counts("validation", ABLATION, ABLATION_SEEDS),
        code=imported_by("tabulate_ablation.py"),
    output:
        table="results/studies/tracker/ablation.csv",
    log:
        "logs/tabulate_ablation.log",
    benchmark:
        "results/benchmarks/tabulate_ablation/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        seed=config["seed"],
        n_bootstrap=config["tracker"]["n_bootstrap"],
        runs=ABLATION_RUNS,
        replicas=ABLATION_SEEDS,
    message:
        "ablation of the training sets, on the validation scenes"
    script:
        "../scripts/tabulate_ablation.py"


use rule tabulate_ablation as tabulate_chosen with:
    input:
        counts=lambda wildcards: [
            f"results/studies/tracker/{setting}/{training_set}/{replica}_test.parquet"
            for setting, training_set in chosen_runs(wildcards)
            for replica in ABLATION_SEEDS
        ],
        code=imported_by("tabulate_ablation.py"),
    output:
        table="results/studies/tracker/chosen.csv",
    log:
        "logs/tabulate_chosen.log",
    benchmark:
        "results/benchmarks/tabulate_chosen/all.tsv"
    params:
        seed=config["seed"],
        n_bootstrap=config["tracker"]["n_bootstrap"],
        runs=chosen_runs,
        replicas=ABLATION_SEEDS,
    message:
        "the best settings on the test scenes"


rule tabulate_seeds:
    input:
        counts=expand(
            "results/tracker/{training_set}/{replica}_counts.parquet",
            training_set=TRAINING_SETS,
            replica=range(STUDY["n_seeds"]),
        ),
        code=imported_by("tabulate_seeds.py"),
    output:
        table="results/studies/tracker/seeds.csv",
    log:
        "logs/tabulate_seeds.log",
    benchmark:
        "results/benchmarks/tabulate_seeds/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        seed=config["seed"],
        n_bootstrap=config["tracker"]["n_bootstrap"],
        training_sets=list(TRAINING_SETS),
        replicas=list(range(STUDY["n_seeds"])),
    message:
        "what {params.replicas} trainings of each set can resolve"
    script:
        "../scripts/tabulate_seeds.py"


rule time_trackers:
    input:
        scenes=benchmark_files("validation"),
        networks=[study_network(name, "rd", 0) for name in ["default", *NETWORKS]],
        counts=[
            f"results/studies/tracker/{name}/rd/0_validation.parquet"
            for name in ["default", *NETWORKS]
        ],
        code=imported_by("time_trackers.py"),
    output:
        table="results/tables/speed_accuracy_tracker.csv",
    log:
        "logs/time_trackers.log",
    benchmark:
        "results/benchmarks/time_trackers/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=2000,
    params:
        names=["default", *NETWORKS],
        n_scenes=5,
        n_rounds=5,
    message:
        "seconds per image of trackers of other width"
    script:
        "../scripts/time_trackers.py"


rule stress_tracker:
    input:
        train=benchmark_files("train"),
        scenes=benchmark_files("validation"),
        network="results/tracker/rd/0.safetensors",
        statistics="results/statistics.nc",
        code=imported_by("stress_tracker.py"),
    output:
        table="results/studies/tracker/stability.csv",
    log:
        "logs/stress_tracker.log",
    benchmark:
        "results/benchmarks/stress_tracker/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=2000,
    params:
        seed=config["seed"],
        settings=config["tracker"]["training"],
        phy=config["phy"],
        stability=STUDY["stability"],
    message:
        "where the tracker fails"
    script:
        "../scripts/stress_tracker.py"


rule study_tracker:
    input:
        "results/studies/tracker/ablation.csv",
        rules.tabulate_chosen.output,
        rules.tabulate_seeds.output,
        rules.time_trackers.output,
        rules.stress_tracker.output,
        *figure_files("study_tracker"),
    message:
        "what makes synthetic data help or hurt the tracker, its cost and where it fails"
