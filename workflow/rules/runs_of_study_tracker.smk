# Which trainings the studies of the tracker are made of, and where their files lie.

import pandas as pd

STUDY = config["studies"]["tracker"]
ABLATION_SEEDS = list(range(STUDY["n_ablation_seeds"]))
# Replicas of the default training sets beyond those of the default run.
MORE_SEEDS = list(range(config["tracker"]["n_seeds"], STUDY["n_seeds"]))
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
