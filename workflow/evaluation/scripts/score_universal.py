"""Edge counts of the tracker that comes with the package on a flight's test scenes."""

import pandas as pd
from main_path import progress, run
from scipy.special import expit

from lib.tracker_scores import count_output
from snowsim.io.files import write_table
from snowsim.io.scenes import SceneSet
from snowsim.io.trackers import read_tracker
from snowsim.tracker.calibration import fused_logits
from snowsim.tracker.portable import network_of_onnx


def score_universal(scenes, weights, counts):
    content, card = read_tracker(weights)
    network = network_of_onnx(content)
    tables = []
    with SceneSet(scenes) as test_scenes:
        for scene in progress(test_scenes, "edge scores"):
            probability = expit(fused_logits(network, scene.image) / card["temperature"])
            table, _ = count_output(probability, scene, "fuse")
            tables.append(table)
    write_table(counts, pd.concat(tables))


run(score_universal)
