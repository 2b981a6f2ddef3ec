"""Types of the names that other code calls; `make lint` checks them, nothing runs this.

Each `assert_type` fails in the checker if an annotation is missing or differs.
"""

from pathlib import Path
from typing import Any, assert_type

import numpy as np
import pandas as pd
import torch
import xarray as xr
from numpy.typing import NDArray

import snowsim
from snowsim import labels, phy, statistics, tracker
from snowsim.echogram import Scene
from snowsim.io import open_segment, read_echogram, read_layers
from snowsim.io.scenes import SceneSet
from snowsim.metrics.edges import THRESHOLDS, match_counts, score, suppress
from snowsim.metrics.image import similarity
from snowsim.metrics.picks import match_picks

Floats = NDArray[np.floating[Any]]
rng = np.random.default_rng(1)
image = np.zeros((300, 256), np.uint8)

echogram = read_echogram(Path("frame.nc"))
assert_type(echogram, xr.Dataset)
layers = read_layers("frame_layers.nc")
assert_type(layers, xr.Dataset)
assert_type(open_segment(["a.nc", Path("b.nc")]), xr.Dataset)

flight = statistics.fit([(echogram, layers)], estimator="deblended")
assert_type(flight, xr.Dataset)
assert_type(statistics.varied(flight, rng=rng), xr.Dataset)

layer_bins = labels.draw(flight, 256, rng=rng)
assert_type(layer_bins, Floats)
model = labels.prepare(flight, 256)
assert_type(model, labels.LabelModel)
assert_type(labels.draw_scene(model, 256, name="a", rng=rng), Scene)

power = phy.mean_power(layer_bins, [1.0, 0.3], [12.0, 12.0], [0.05, 0.09], 300)
assert_type(power, Floats)
assert_type(phy.draw_speckle(power, 16, method="gamma", rng=rng), Floats)
parameters = {"peak_power": [1.0], "noise_power": 1e-3}
assert_type(phy.render(layer_bins, parameters, 300, rng=rng), Floats)

assert_type(similarity(image, image), dict[str, float])
counts = match_counts(suppress(power), image > 0, THRESHOLDS)
assert_type(counts, dict[str, NDArray[np.integer[Any]]])
assert_type(score([counts], THRESHOLDS), dict[str, float])
assert_type(match_picks(layer_bins, layer_bins), tuple[Floats, NDArray[np.bool_]])

with SceneSet(["a.nc", "b.nc"]) as read:
    assert_type(read[0], Scene)
    assert_type(read[0].mask(), NDArray[np.bool_])

drawn = snowsim.scenes(8, rng=1)
assert_type(drawn[0], tuple[NDArray[np.uint8], NDArray[np.uint8]])
assert_type(drawn.scene(0), Scene)
assert_type(snowsim.score_folders("maps", Path("truth")), pd.DataFrame)
seen, truth = snowsim.simulate(
    snowsim.Climate(accumulation_m=0.3), snowsim.Radar.preset("snow-2012"), rng=1
)
assert_type(truth, xr.Dataset)

universal = snowsim.Tracker.from_pretrained("universal")
assert_type(universal, snowsim.Tracker)
assert_type(universal.annotate(seen), xr.DataArray)
assert_type(universal.pick(seen), xr.Dataset)
assert_type(snowsim.accumulation(layers, 350.0, year={"snow_1": 2011}), xr.Dataset)
assert_type(snowsim.agreement([layers, layers]), xr.Dataset)

training = tracker.Training(tracker.Settings(), seed=1)
for step, losses in tracker.train_steps(training, tracker.TrainingSet([], [], seed=1)):
    assert_type(step, int)
    assert_type(losses, dict[str, float])
network = tracker.trained_network({}, tracker.Settings())
assert_type(network, torch.nn.Module)
assert_type(tracker.track(network, image), NDArray[np.float32])
