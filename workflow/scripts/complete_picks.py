"""Complete the picks of observed train scenes, by the tracker that comes with the package."""

from job import logger, progress, run
from scipy.special import expit

from snowsim.cgan.unpicked import completed as completed_by
from snowsim.io.scenes import SceneSet, write_scenes
from snowsim.io.trackers import read_tracker
from snowsim.tracker.calibration import fused_logits
from snowsim.tracker.portable import network_of_onnx


def complete_picks(scenes, weights, completed, *, bin_s, source):
    """ValueError if range bins of `bin_s` [s] are none that the tracker was trained for."""
    content, card = read_tracker(weights)
    least, most = card["ranges"]["bin_s"]
    if not least <= bin_s <= most:
        msg = f"cgan.picks: completed: the tracker knows range bins of {least:g} to {most:g} s, "
        msg += f"got {bin_s:g}; use cgan.picks: as_picked"
        raise ValueError(msg)
    network = network_of_onnx(content)
    n_new = 0

    def marked(observed):
        nonlocal n_new
        for scene in progress(observed, "picks"):
            probability = expit(fused_logits(network, scene.image) / card["temperature"])
            found = completed_by(scene, probability, threshold=card["threshold"])
            n_new += len(found.layer_bins) - len(scene.layer_bins)
            yield found

    with SceneSet(scenes) as observed:
        write_scenes(completed, marked(observed), {"synthetic": source})
        logger.info("%d pieces of layers in %d scenes were not picked", n_new, len(observed))


run(complete_picks)
