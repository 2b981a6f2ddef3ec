"""Cost of trainings and of the scenes they see, and their scores on validation scenes."""

from datetime import date
from pathlib import Path

import pandas as pd
from main_path import ROOT, job

from evaluation.lib.studied import studied_set
from pretrained.card import commit_of
from snowsim.io.files import read_table, write_table


def core_seconds(place):
    """Seconds of a core held by the jobs whose benchmarks lie at a place, a file or a folder.

    Snakemake's CPU time lacks the last half minute of a job.
    """
    path = Path(snakemake.params.benchmarks, place)
    files = [path] if path.is_file() else path.glob("*.tsv")
    return sum(pd.read_csv(file, sep="\t")["s"].sum() for file in files)


def costs(row):
    """Core-seconds of a training, and of the scenes that it was added."""
    training = f"train_studied/{row.training_set}/{row.n_gradients}/{row.replica}.tsv"
    rules = [snakemake.params.made_by[name] for name in studied_set(row.training_set).added]
    return {
        "training_s": core_seconds(training),
        "scenes_s": sum(map(core_seconds, sum(rules, []))),
    }


with job(snakemake):
    scores = pd.concat(map(read_table, snakemake.input.scores), ignore_index=True)
    of_runs = pd.DataFrame([costs(row) for row in scores.itertuples()])
    today = {"commit": commit_of(ROOT), "date": date.today().isoformat()}
    write_table(snakemake.output.budgets, pd.concat([scores, of_runs], axis=1).assign(**today))
    write_table(snakemake.output.depths, pd.concat(map(read_table, snakemake.input.depths)))
