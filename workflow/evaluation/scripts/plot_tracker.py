"""Figures of the trackers; the first replica of every training set is shown on test scenes."""

from main_path import job, progress

from evaluation.lib.figures import tracker
from evaluation.lib.figures.style import Scale, save_figure
from lib.tracker_scores import read_tracker
from snowsim.io.files import read_dataset, read_table
from snowsim.io.scenes import SceneSet

with job(snakemake):
    tables = snakemake.input
    output = snakemake.output
    params = snakemake.params
    curves = tracker.precision_recall(read_table(tables.precision_recall))
    save_figure(output.precision_recall_svg, curves, params.source)
    with SceneSet(tables.scenes) as test_scenes:
        scenes = tracker.scenes_to_show(test_scenes)
    outputs = {}
    picked = {}
    trained = zip(params.training_sets, tables.networks, tables.rows_of_picks, strict=True)
    for training_set, network, rows in progress(trained, "trackers", len(params.training_sets)):
        trained_tracker = read_tracker(network, params.device)
        outputs[training_set] = [trained_tracker.track(scene.image) for scene in scenes]
        threshold = read_table(rows)["threshold"].iloc[0]
        picked[training_set] = tracker.fused_picks(outputs[training_set][-1], threshold)
    save_figure(output.side_outputs_png, tracker.side_outputs(scenes, outputs), params.source)
    scale = Scale.of(read_dataset(tables.statistics), params.snow_density_kg_m3)
    errors = read_table(tables.picks)
    by_depth = read_table(tables.picks_by_depth)
    picks = tracker.picks(errors, by_depth, scenes[-1], picked, scale)
    save_figure(output.picks_svg, picks, params.source)
