# What makes synthetic data help or hurt the tracker, and what the default number of trainings can resolve. Not part of
# the default run: snakemake study_tracker. Settings are compared on the held-out validation scenes; of those that leave
# labels, steps and PHY as they are, the best is scored on the test scenes, once.

import pandas as pd

STUDY = config["studies"]["tracker"]
ABLATION_SEEDS = list(range(STUDY["n_ablation_seeds"]))
ABLATION = {
    "default": {"training_sets": list(TRAINING_SETS)},
    **{setting["name"]: setting for setting in STUDY["ablation"]},
}
ABLATION_RUNS = [
    (setting, training_set)
    for setting, changes in ABLATION.items()
    for training_set in changes["training_sets"]
]
# Networks of other cost, on real scenes alone.
NETWORKS = {
    network["name"]: {"training_sets": ["rd"], **network}
    for network in STUDY["networks"]
}
STUDIED = {**ABLATION, **NETWORKS}
names = [setting["name"] for setting in STUDY["ablation"] + STUDY["networks"]]
for name in names:
    if names.count(name) > 1:
        raise WorkflowError(
            f"config: studies.tracker: expected every name once, got {name} {names.count(name)} times"
        )
# What a reader of the paper would take for the same experiment.
CANDIDATES = [
    setting
    for setting, changes in ABLATION.items()
    if not {"labels", "steps", "phy"} & set(changes)
]


wildcard_constraints:
    setting="|".join(setting for setting in STUDIED if setting != "default"),
    any_setting="|".join(STUDIED),


def study_added_scenes(method):
    """Input function: the label sets that join the real scenes, as PHY of the setting renders them."""

    def files(wildcards):
        if method not in TRAINING_SETS[wildcards.training_set]:
            return []
        if method == "phy" and "phy" in STUDIED[wildcards.setting]:
            return expand(
                "results/studies/tracker/{setting}/phy/{shard}.nc",
                setting=wildcards.setting,
                shard=shards("labels"),
            )
        return rendered_files(method, "labels")

    return files


def study_statistics(wildcards):
    """The flight's statistics by the estimator of a setting."""
    estimator = STUDIED[wildcards.setting]["phy"].get(
        "estimator", config["statistics"]["estimator"]
    )
    if estimator == config["statistics"]["estimator"]:
        return "results/statistics.nc"
    return f"results/closed_loop/flight_{estimator}.nc"


def study_data(wildcards):
    """How scenes are put together in a setting."""
    changes = STUDIED[wildcards.setting]
    kept = {"order", "labels", "zones", "n_layers", "added_per_real"}
    return {
        "added_per_real": config["tracker"]["added_per_real"],
        "order": config["tracker"]["order"],
        "n_layers": config["tracker"]["added_layers"],
        **{key: value for key, value in changes.items() if key in kept},
    }


def study_settings(wildcards):
    """How the network is trained in a setting."""
    changes, training = STUDIED[wildcards.setting], config["tracker"]["training"]
    return {
        **training,
        "n_steps": round(training["n_steps"] * changes.get("steps", 1)),
        **changes.get("training", {}),
    }


def study_epochs(wildcards):
    """Epochs in a setting, where they and not steps are set."""
    n_epochs = config["tracker"]["n_epochs"]
    steps = STUDIED[wildcards.setting].get("steps", 1)
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


def chosen_runs(wildcards):
    """Default and best candidate of every training set, by the fused ODS on the validation scenes."""
    table = pd.read_csv(checkpoints.tabulate_ablation.get().output.table)
    table = table[(table["metric"] == "ods") & table["setting"].isin(CANDIDATES)]
    best = table.loc[table.groupby("training_set")["mean"].idxmax()]
    chosen = [
        tuple(run) for run in best[["setting", "training_set"]].to_numpy().tolist()
    ]
    default = [("default", training_set) for training_set in TRAINING_SETS]
    return default + [run for run in chosen if run not in default]


checkpoint tabulate_ablation:
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


use rule tabulate_ablation as tabulate_chosen with:
    input:
        counts=lambda wildcards: [
            f"results/studies/tracker/{setting}/{training_set}/{replica}_test.parquet"
            for setting, training_set in chosen_runs(wildcards)
            for replica in ABLATION_SEEDS
        ],
        code=package("metrics", "io.files"),
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
        code=package("metrics", "io.files"),
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
        code=package(
            "tracker",
            "patches",
            "weights",
            "metrics",
            "timing",
            "io.files",
            "io.models",
            "io.scenes",
        ),
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
        code=package(
            "tracker",
            "patches",
            "weights",
            "metrics",
            "phy",
            "io.files",
            "io.models",
            "io.scenes",
        ),
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


rule plot_study_tracker:
    input:
        ablation="results/studies/tracker/ablation.csv",
        chosen="results/studies/tracker/chosen.csv",
        seeds="results/studies/tracker/seeds.csv",
        speed="results/tables/speed_accuracy_tracker.csv",
        stability="results/studies/tracker/stability.csv",
        code=package("plotting", "io.figures", "io.files"),
    output:
        ablation=report(
            "results/figures/tracker_ablation.svg",
            caption="../report/tracker_ablation.rst",
        ),
        seeds=report(
            "results/figures/tracker_seeds.svg", caption="../report/tracker_seeds.rst"
        ),
        speed=report(
            "results/figures/speed_accuracy_tracker.svg",
            caption="../report/speed_accuracy_tracker.rst",
        ),
        stability=report(
            "results/figures/stability_tracker.svg",
            caption="../report/stability_tracker.rst",
        ),
    log:
        "logs/plot_study_tracker.log",
    benchmark:
        "results/benchmarks/plot_study_tracker/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        source=NOTE,
    message:
        "figures of the studies of the tracker"
    script:
        "../scripts/plot_study_tracker.py"


rule study_tracker:
    input:
        "results/studies/tracker/ablation.csv",
        rules.tabulate_chosen.output,
        rules.tabulate_seeds.output,
        rules.time_trackers.output,
        rules.stress_tracker.output,
        rules.plot_study_tracker.output,
    message:
        "what makes synthetic data help or hurt the tracker, its cost and where it fails"
