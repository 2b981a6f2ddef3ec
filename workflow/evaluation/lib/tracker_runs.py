"""Which trainings the study of the tracker is made of.

Settings, and how each differs from the default.

A setting is what changes: `training_sets`, and any of `labels`, `order`, `added_per_real`,
`steps` (a factor), `skip` (a share), `draw` (of label sets of its own), `phy` and `training`. A run
is a pair of names, (setting, training set). `tracker` is the section of the configuration.
"""

from collections import Counter
from itertools import chain
from pathlib import Path


def ablation_of(study):
    """Settings of the study by name, the default first, in all training sets of the others."""
    used = chain.from_iterable(each["training_sets"] for each in study["ablation"])
    settings = {"default": {"training_sets": list(dict.fromkeys(used))}}
    for each in study["ablation"]:
        settings[each["name"]] = each
    return settings


def check_names(study):
    """ValueError where two settings share a name, or a worth is that of an unknown setting."""
    names = [each["name"] for each in study["ablation"]]
    for name, times in Counter(names).items():
        if times > 1:
            msg = f"config: studies.tracker: expected every name once, got {name} {times} times"
            raise ValueError(msg)
    known = ["default", *names]
    for setting, _ in chain.from_iterable(worth_of(study)):
        if setting not in known:
            wanted = f"a setting, one of {', '.join(known)}"
            msg = f"config: studies.tracker.worth: expected {wanted}, got {setting}"
            raise ValueError(msg)


def worth_of(study):
    """Pairs of runs, (setting, training set), whose difference is the worth of the first."""
    return [tuple(map(_run, pair)) for pair in study["worth"]]


def _run(name):
    """Run of a name, `setting/training set`, or of a training set alone: that of the default."""
    setting, _, training_set = name.rpartition("/")
    return setting or "default", training_set


def pairs_of(runs):
    """Every run and its base, the default of the same training set."""
    return [(run, ("default", run[1])) for run in runs]


def data_of(changes, tracker):
    """How scenes are put together in a setting."""
    data = {"added_per_real": tracker["added_per_real"], "order": tracker["order"]}
    for key in ("order", "labels", "added_per_real"):
        if key in changes:
            data[key] = changes[key]
    return data


def training_of(changes, tracker):
    """How the network is trained in a setting."""
    training = tracker["training"]
    n_steps = round(training["n_steps"] * changes.get("steps", 1))
    return {**training, "n_steps": n_steps, **changes.get("training", {})}


def epochs_of(changes, tracker):
    """Epochs in a setting, where they and not steps are set."""
    n_epochs = tracker["n_epochs"]
    return None if n_epochs is None else max(1, round(n_epochs * changes.get("steps", 1)))


def phy_of(changes, phy):
    """Conventions of PHY in a setting, from those of the configuration.

    The estimator of the statistics is no convention of PHY.
    """
    conventions = phy | changes.get("phy", {})
    conventions.pop("estimator", None)
    return conventions


def estimator_of(changes, config):
    """Estimator of the statistics that PHY of a setting renders with."""
    return changes.get("phy", {}).get("estimator", config["statistics"]["estimator"])


def draws(changes):
    """Whether a setting has label sets of its own, not the default's."""
    return "draw" in changes


def labels_of(changes, labels):
    """How label sets are drawn in a setting, from `labels` of the configuration."""
    return labels | changes["draw"]


def choices_of(changes, choices, phy):
    """`choices` of the label sets, each as PHY of a setting has it."""
    of_setting = phy_of(changes, phy)
    return {name: of_setting[name] for name in choices}


def renders_of(setting, changes, files):
    """Label sets as PHY of a setting renders them.

    Of its own where it changes PHY or draws label sets, else `files`, the default's.
    """
    if "phy" not in changes and not draws(changes):
        return files
    return [f"results/studies/tracker/{setting}/phy/{Path(file).name}" for file in files]


def network_file(setting, training_set, replica):
    """Where the network of a setting lies; that of the default is Table III's."""
    folder = "tracker" if setting == "default" else f"studies/tracker/{setting}"
    return f"results/{folder}/{training_set}/{replica}.safetensors"


def count_files(split, runs, replicas):
    """Where the counts of the fused output of every replica of some runs lie."""
    return [
        f"results/studies/tracker/{setting}/{training_set}/{replica}_{split}.parquet"
        for setting, training_set in runs
        for replica in replicas
    ]
