"""Tables of what was drawn beside the flight it was drawn from."""

from main_path import progress, run

from evaluation.lib.label_summary import summarise_labels
from snowsim.io.files import read_dataset, write_table
from snowsim.io.scenes import SceneSet
from snowsim.statistics import merge, summary_from_dataset


def summarise(statistics, summaries, labels, **tables):
    summary = merge(summary_from_dataset(read_dataset(path)) for path in summaries)
    with SceneSet(labels) as scenes:
        made = summarise_labels(progress(scenes, "labels"), read_dataset(statistics), summary)
    for name, path in tables.items():
        write_table(path, made[name])


run(summarise)
