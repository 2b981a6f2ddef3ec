# What makes synthetic data help or hurt the tracker, and what the default number of trainings can resolve. Not part of
# the default run: snakemake study_tracker. Settings are compared on the held-out validation scenes; of those that leave
# labels, steps and PHY as they are, the best is scored on the test scenes, once.

STUDY = config["studies"]["tracker"]
ABLATION_SEEDS = list(range(STUDY["n_ablation_seeds"]))
ABLATION = {"default": {"training_sets": list(TRAINING_SETS)}, **STUDY["ablation"]}
ABLATION_RUNS = [
    (setting, training_set)
    for setting, changes in ABLATION.items()
    for training_set in changes["training_sets"]
]
# What a reader of the paper would take for the same experiment.
CANDIDATES = [
    setting
    for setting, changes in ABLATION.items()
    if not {"labels", "steps", "phy"} & set(changes)
]


wildcard_constraints:
    setting="|".join(STUDY["ablation"]),
    any_setting="|".join(ABLATION),


def study_added_scenes(method):
    """Input function: the label sets that join the real scenes, as PHY of the setting renders them."""

    def files(wildcards):
        if method not in TRAINING_SETS[wildcards.training_set]:
            return []
        if method == "phy" and "phy" in ABLATION[wildcards.setting]:
            return expand(
                "results/studies/tracker/{setting}/phy/{shard}.nc",
                setting=wildcards.setting,
                shard=shards("labels"),
            )
        return rendered_files(method, "labels")

    return files


def study_statistics(wildcards):
    """The flight's statistics by the estimator of a setting."""
    estimator = ABLATION[wildcards.setting]["phy"].get(
        "estimator", config["statistics"]["estimator"]
    )
    if estimator == config["statistics"]["estimator"]:
        return "results/statistics.nc"
    return f"results/closed_loop/flight_{estimator}.nc"


def study_data(wildcards):
    """How scenes are put together in a setting."""
    changes = ABLATION[wildcards.setting]
    kept = {"order", "labels", "zones", "added_per_real"}
    return {
        "added_per_real": config["tracker"]["added_per_real"],
        **{key: value for key, value in changes.items() if key in kept},
    }


def study_settings(wildcards):
    """How the network is trained in a setting."""
    changes, training = ABLATION[wildcards.setting], config["tracker"]["training"]
    return {
        **training,
        "n_steps": round(training["n_steps"] * changes.get("steps", 1)),
        **changes.get("training", {}),
    }


def study_epochs(wildcards):
    """Epochs in a setting, where they and not steps are set."""
    n_epochs = config["tracker"]["n_epochs"]
    steps = ABLATION[wildcards.setting].get("steps", 1)
    return None if n_epochs is None else max(1, round(n_epochs * steps))


def study_network(setting, training_set, replica):
    """Where the network of a setting lies; that of the default is Table III's."""
    folder = "tracker" if setting == "default" else f"studies/tracker/{setting}"
    return f"results/{folder}/{training_set}/{replica}.safetensors"


def study_counts(split, settings, seeds):
    """Counts of the fused output of every training of some settings."""
    return [
        f"results/studies/tracker/{setting}/{training_set}/{replica}_{split}.parquet"
        for setting, training_set in ABLATION_RUNS
        if setting in settings
        for replica in seeds
    ]


use rule render_phy as render_study_phy with:
    input:
        layers="results/labels/{shard}.nc",
        statistics=study_statistics,
        code=package("phy", "io.files", "io.scenes"),
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
                for key, value in ABLATION[wildcards.setting]["phy"].items()
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
        code=package(
            "tracker", "patches", "weights", "io.files", "io.models", "io.scenes"
        ),
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
        network=lambda wildcards: study_network(
            wildcards.any_setting, wildcards.training_set, wildcards.replica
        ),
        code=package(
            "tracker",
            "patches",
            "weights",
            "metrics",
            "io.files",
            "io.models",
            "io.scenes",
        ),
    output:
        counts="results/studies/tracker/{any_setting}/{training_set}/{replica}_{split}.parquet",
    log:
        "logs/score_study_tracker/{any_setting}/{training_set}/{replica}_{split}.log",
    benchmark:
        "results/benchmarks/score_study_tracker/{any_setting}/{training_set}/{replica}_{split}.tsv"
    params:
        device=config["tracker"]["device"],
        outputs=["fuse"],
    message:
        "fused edge scores of {wildcards.training_set}, {wildcards.any_setting}, replica {wildcards.replica}"


rule tabulate_ablation:
    input:
        counts=study_counts("validation", ABLATION, ABLATION_SEEDS),
        code=package("metrics", "io.files"),
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


rule study_tracker:
    input:
        rules.tabulate_ablation.output,
    message:
        "what makes synthetic data help or hurt the tracker"
