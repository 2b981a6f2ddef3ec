"""Cost of trainings and of the scenes they see, and their ODS on validation scenes."""

from datetime import date
from pathlib import Path

import pandas as pd
from main_path import ROOT, job, progress

from lib.score_tables import counts_by_image
from lib.tracker_scores import count_edges, read_tracker
from pretrained.card import commit_of
from snowsim.io.files import write_table
from snowsim.io.scenes import SceneSet
from snowsim.metrics.edges import score


def core_seconds(place):
    """Seconds of a core held by the jobs whose benchmarks lie at a place, a file or a folder.

    Snakemake's CPU time lacks the last half minute of a job.
    """
    path = Path(snakemake.params.benchmarks, place)
    files = [path] if path.is_file() else path.glob("*.tsv")
    return sum(pd.read_csv(file, sep="\t")["s"].sum() for file in files)


with job(snakemake), SceneSet(snakemake.input.scenes) as scenes:
    rows = []
    runs = zip(snakemake.params.runs, snakemake.input.networks, strict=True)
    for (name, n_gradients, replica), network in progress(list(runs), "trackers"):
        counts, _ = count_edges(read_tracker(network).calibrated(scenes), scenes, ["fuse"])
        row = {
            "training_set": name,
            "n_gradients": n_gradients,
            "replica": replica,
            "training_s": core_seconds(f"train_budget/{name}/{n_gradients}/{replica}.tsv"),
            "scenes_s": sum(map(core_seconds, snakemake.params.made_by[name])),
            "ods": score(counts_by_image(counts, "fuse"))["ods"],
            "commit": commit_of(ROOT),
            "date": date.today().isoformat(),
        }
        rows.append(row)
    write_table(snakemake.output.budgets, pd.DataFrame(rows))
