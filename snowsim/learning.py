"""Training of a tracker on a user's scenes, for the command `snowsim train`; needs torch."""

import hashlib
import warnings
from pathlib import Path

import numpy as np
from torch.utils.data import ConcatDataset, Subset

from snowsim.io.models import read_tracker, shipped_trackers, write_tracker
from snowsim.limits import check_count, check_values
from snowsim.metrics.edges import score, select_images, stack_counts
from snowsim.progress import with_progress
from snowsim.tracker import (
    Settings,
    Training,
    TrainingSet,
    calibrate,
    edge_counts,
    fused_logits,
    make_card,
    network_of_onnx,
    to_onnx,
    train_steps,
    trained_network,
)
from snowsim.tracker.card import NUMBERS
from snowsim.training import check_device, load_weights

# Size of a network that starts from random weights.
WIDTH = 8
N_AVERAGED = 2
BIN_S = 2.886e-10
LINE_SPACING_M = 5.2
SPACINGS = {"bin_size_s": ("range bins", "s"), "line_spacing_m": ("range lines", "m")}
SAME = 1e-6  # relative difference up to which two spacings are the same
HELD_OUT_ONE_IN = 10  # one scene in this many is held out for the calibration
LEAST_SCORED = 10  # fewest held-out scenes for which a score is reported
N_BOOTSTRAP = 1000


def train_tracker(path, sets, *, start=None, n_steps, seed, bin_s, line_spacing_m, device="cpu"):
    """Train a tracker on sets of scenes; write it to `path` as ONNX, and its card beside it.

    Parameters
    ----------
    path : path_like
        Ends in ``.onnx``.
    sets : sequence of sequence of Scene
        Scenes with images. Every tenth, and at least one, is held out to calibrate the tracker.
        In a held-out scene, layers without annotation count as background.
    start : str, optional
        Tracker whose weights the training starts from: the name of one that comes with the package,
        or a file that this function wrote. By default weights start at random.
    n_steps : int
        Number of training steps, each with the gradient of four crops.
    seed : int
    bin_s : float or None
        Length of a range bin of the scenes [s], for the card. If None, it is taken from the
        notes of the scenes; if they do not hold it, it is `BIN_S`.
    line_spacing_m : float or None
        Distance between range lines of the scenes [m], for the card. If None, it is taken from the
        notes of the scenes; if they do not hold it, it is `LINE_SPACING_M`.
    device : str
        Device to train on, `cpu` or `cuda`.

    Returns
    -------
    dict
        The card. It has no ranges, so that no pick of this tracker is rated good: how sure its
        picks are was not measured, also where it starts from another tracker. Its `held_out` holds
        `n_scenes`, the number of held-out scenes. With ten scenes or more, it also holds the `ods`
        of the fused output, and `low` and `high`, the ends of its 95 % interval by bootstrap over
        scenes.

    Raises
    ------
    ValueError
        If there are fewer than 2 scenes, if one cannot be trained on or has another spacing, if two
        have the same image, if `start` is no tracker, or if `device` asks for a GPU and there is
        none.
    """
    check_device(device)
    scenes = ConcatDataset(sets)
    check_count("number of scenes, one for the calibration,", len(scenes), 2)
    _refuse_copies(sets)
    bin_s = _spacing(scenes, "bin_size_s", bin_s, BIN_S)
    line_spacing_m = _spacing(scenes, "line_spacing_m", line_spacing_m, LINE_SPACING_M)
    for name, value in (("bin_s", bin_s), ("line_spacing_m", line_spacing_m)):
        check_values(name, value, *NUMBERS[name])
    shape = {"width": WIDTH, "n_averaged": N_AVERAGED}
    if start is not None:
        start_network, _ = network_of_tracker(start)
        shape = {name: getattr(start_network, name) for name in shape}
        shape["network"] = start_network.kind
    training = Training(Settings(**shape, n_steps=n_steps), seed=seed, device=device)
    if start is not None:
        load_weights(training.network, start_network.state_dict(), str(start))
    held_out = Subset(scenes, range(0, len(scenes), HELD_OUT_ONE_IN))
    train_scenes = Subset(scenes, [n for n in range(len(scenes)) if n % HELD_OUT_ONE_IN])
    steps = train_steps(training, TrainingSet(train_scenes, seed=seed))
    with with_progress(None, n_steps, unit="gradient") as bar:
        for step, _ in steps:
            bar.update(step - bar.n)
    network = trained_network(training.network.state_dict(), training.settings)
    logits = [fused_logits(network, scene.image) for scene in held_out]
    calibration = calibrate(logits, held_out)
    origin = "" if start is None else f", starting from {start}"
    card = make_card(
        Path(path).stem,
        calibration,
        trained_on=(
            f"{len(train_scenes)} scenes of the user's, {n_steps} gradients of 4 crops{origin}"
        ),
        bin_s=bin_s,
        line_spacing_m=line_spacing_m,
        limits=f"calibrated on {len(held_out)} scenes of the same set",
    )
    card["held_out"] = held_out_score([calibration.probability(each) for each in logits], held_out)
    if len(held_out) < LEAST_SCORED:
        card["calibration_ods"] = None
    write_tracker(path, to_onnx(network, calibration.offset), card)
    return card


def held_out_score(probability, scenes):
    """Number of held-out scenes and, for ten or more, the ODS of their maps with its interval."""
    result = {"n_scenes": len(scenes)}
    if len(scenes) < LEAST_SCORED:
        return result
    counts = stack_counts(edge_counts(probability, scenes)[0])
    draws = np.random.default_rng(0).integers(len(scenes), size=(N_BOOTSTRAP, len(scenes)))
    resampled = [score(select_images(counts, draw))["ods"] for draw in draws]
    low, high = np.percentile(resampled, [2.5, 97.5])
    found = {"ods": score(counts)["ods"], "low": low, "high": high}
    return result | {name: round(float(value), 4) for name, value in found.items()}


def _refuse_copies(sets):
    """Raise ValueError if two scenes have one image: that held out must not be trained on, too."""
    firsts, copies = {}, []
    for number, scenes in enumerate(sets, start=1):
        for scene in scenes:
            digest = hashlib.sha256(repr(scene.image.shape).encode() + scene.image.tobytes())
            own = f"{scene.name} of set {number}"
            first = firsts.setdefault(digest.digest(), own)
            if first is not own:
                copies.append(f"{own} is {first}")
    if copies:
        msg = (
            f"scenes: expected images that differ, as every tenth is held out, found {len(copies)} "
            f"copies: {copies[0]} (snowsim scenes draws others with another --seed)"
        )
        raise ValueError(msg)


def _spacing(scenes, name, given, usual):
    """Spacing of scenes: the given one, else that in their notes, else the usual, with a warning.

    A warning, too, if some scenes do not tell theirs. ValueError if two spacings differ.
    """
    what, unit = SPACINGS[name]
    found = given
    n_silent = 0
    for scene in scenes:
        own = scene.notes.get(name)
        if own is None:
            n_silent += 1
            continue
        found = found or own
        if abs(own / found - 1) > SAME:
            msg = (
                f"scene {scene.name}: expected {what} of {found:.4g} {unit}, as given or in "
                f"scenes before it, found {own:.4g} {unit}"
            )
            raise ValueError(msg)
    if found is None:
        msg = f"scenes do not state the spacing of their {what}: {usual:.4g} {unit} assumed"
        warnings.warn(msg, stacklevel=3)
    elif n_silent and given is None:
        msg = (
            f"{n_silent} of {len(scenes)} scenes do not state the spacing of their {what}: "
            f"{found:.4g} {unit}, that of the others, assumed"
        )
        warnings.warn(msg, stacklevel=3)
    return found or usual


def network_of_tracker(name):
    """Network and card of a tracker, by its name in the package or the path of its file."""
    shipped = shipped_trackers()
    path = Path(shipped.get(name, name))
    if not path.is_file():
        known = ", ".join(shipped)
        msg = f"{name}: expected a tracker that comes with the package ({known}) or an .onnx file"
        raise ValueError(msg)
    content, card = read_tracker(path)
    return network_of_onnx(content), card
