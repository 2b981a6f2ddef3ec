"""Signs that a training of the conditional GAN has collapsed, and the limits of each.

Each limit was set before it was tried, for the reason stated beside it; where one had to be moved
or added, that is said there, and the ten healthy trainings of the tests were drawn afterwards.
"""

from dataclasses import replace

import numpy as np

from snowsim.cgan.render import render
from snowsim.seeding import random_stream

UNDECIDED = np.log(2)  # loss of a discriminator that always says one half
WINDOW_STEPS = 200  # the loss of one step scatters by about a half: a mean over these by 0.04
N_SCENES = 4
PERIODS = (2, 4, 8)  # [pixels] of the three outermost transposed convolutions

# Below a tenth of the undecided loss it is right with 93 % confidence everywhere: its gradient for
# the generator is mostly noise.
SATURATED = 0.1
# One that always says the same has a ratio of 1 or more; 0.001 for rounding. The limit was 0.98
# from the first validation on, until healthy trainings stood at 0.993 after half of their steps and
# at 0.992 after three quarters: the better renders are, the less there is to tell.
IDLE = 0.999
LATE_SHARE = 0.75
# Renders of different masks that differ by less than a quarter of what the observed scenes differ
# by ignore the mask: speckle alone, equal in none, makes observed scenes differ by about a third of
# their whole difference.
MASK_RESPONSE = 0.25
# Half a grey level is what rounding to 8 bits hides: dropout that does less does nothing.
DRAW_SPREAD = 0.5
# A plain grey image of the observed mean errs as much: a render that errs more has learnt nothing.
# Added when trainings at a hundred times the rate were found to answer to the mask. Three quarters
# would find one more of eleven of those, and small healthy trainings with them.
ERROR_SHARE = 1.0
# Speckle of 16 looks has 7 grey levels: a pattern of three shows through it. It was 1 at first, the
# finest pattern that 8 bits hold: a healthy training reached 1.05. Scenes with flat layers hold
# some themselves.
CHECKERBOARD = 3.0
CHECKERBOARD_OBSERVED = 3.0  # times that of the observed scenes


def measure_losses(losses):
    """`discriminator_ratio`: discriminator loss over the last `WINDOW_STEPS` steps, by `UNDECIDED`.

    `losses` of the steps so far, as `train_steps` yields them; nothing without a discriminator.
    """
    late = losses[-WINDOW_STEPS:]
    if "discriminator_real" not in late[-1]:
        return {}
    mean = np.mean([(step["discriminator_real"] + step["discriminator_fake"]) / 2 for step in late])
    return {"discriminator_ratio": float(mean / UNDECIDED)}


def measure_renders(generator, scenes, settings, *, seed):
    """What the renders of the first `N_SCENES` observed scenes depend on, and their patterns.

    A dict of `mask_response`: root mean square difference between renders of different masks by the
    same dropout, as a share of that between the observed images; `draw_spread`: the same between
    two draws for one mask [grey levels]; `error_share`: root mean square error as a share of the
    observed images' standard deviation; `checkerboard` and `checkerboard_observed` [grey levels].
    NaN if a render is not finite; ValueError for fewer than two scenes. Scenes are cut to the
    smallest of them; `settings` as for `render`.
    """
    scenes = scenes[:N_SCENES]
    if len(scenes) < 2:
        msg = f"health is measured on two or more scenes, got {len(scenes)}"
        raise ValueError(msg)
    height = min(scene.n_range_bins for scene in scenes)
    width = min(scene.n_range_lines for scene in scenes)
    cut = [_cut(scene, height, width) for scene in scenes]
    observed = np.stack([scene.image for scene in cut]).astype(float)

    def rendered(draw):
        images = []
        for scene in cut:
            rng = random_stream(seed, "cgan", "health", draw)  # the same for every scene
            try:
                images.append(render(generator, scene, settings, rng=rng))
            except FloatingPointError:
                return np.full(observed.shape, np.nan)
        return np.stack(images).astype(float)

    first = rendered(1)
    second = rendered(2)
    with np.errstate(invalid="ignore", divide="ignore"):
        return {
            "mask_response": _difference(first) / _difference(observed),
            "draw_spread": _root_mean_square(first - second),
            "error_share": float(_root_mean_square(first - observed) / observed.std()),
            "checkerboard": float(np.mean([checkerboard(image) for image in first])),
            "checkerboard_observed": float(np.mean([checkerboard(image) for image in observed])),
        }


def checkerboard(image):
    """Strength of patterns that repeat every 2, 4 or 8 pixels [grey levels].

    Transposed convolutions leave such. The strongest of the periods: standard deviation of the
    median over all cells of a grid of that period, each less its mean and what is the same along a
    row, which might be snow. Layers and edges, bright in few, move no median.
    """
    image = np.asarray(image, dtype=float)
    strengths = []
    for period in PERIODS:
        rows, columns = (length // period for length in image.shape)
        if rows == 0 or columns == 0:
            continue
        cells = image[: rows * period, : columns * period].reshape(rows, period, columns, period)
        cells = cells - cells.mean(axis=(1, 3), keepdims=True)
        pattern = np.median(cells, axis=(0, 2))
        uneven = pattern - pattern.mean(axis=1, keepdims=True)
        strengths.append(float(uneven.std()))
    return max(strengths)


def is_early(step, n_steps):
    """Whether a discriminator may still be idle after `step` steps."""
    return step < LATE_SHARE * n_steps


def faults(numbers, *, dropout, early=False):
    """What is wrong by the limits of this module, a phrase each; empty for a healthy training.

    `numbers` of `measure_losses` and `measure_renders`, missing ones not checked. Without dropout
    draws may be equal; `early` in a training its discriminator may be idle.
    """
    ratio = numbers.get("discriminator_ratio", 0.5)
    response = numbers.get("mask_response", 1.0)
    spread = numbers.get("draw_spread", np.inf)
    error = numbers.get("error_share", 0.0)
    pattern = numbers.get("checkerboard", 0.0)
    of_observed = numbers.get("checkerboard_observed", 0.0)
    limit = max(CHECKERBOARD, CHECKERBOARD_OBSERVED * of_observed)
    if not np.isfinite([ratio, response, pattern]).all() or np.isnan(spread):
        return ["values that are not finite"]
    found = []
    if ratio < SATURATED:
        found.append(
            f"discriminator saturated: its loss is {ratio:.3f} of an undecided one's, "
            f"below {SATURATED}"
        )
    if ratio > IDLE and not early:
        found.append(
            f"discriminator idle: its loss is {ratio:.3f} of an undecided one's, above {IDLE}"
        )
    if response < MASK_RESPONSE:
        found.append(
            f"mask ignored: renders differ by {response:.3f} of what scenes do, "
            f"below {MASK_RESPONSE}"
        )
    if error > ERROR_SHARE:
        found.append(
            f"nothing learnt: renders err by {error:.2f} of the contrast, above {ERROR_SHARE}"
        )
    if dropout > 0 and spread < DRAW_SPREAD:
        found.append(
            f"dropout ignored: draws differ by {spread:.3f} grey levels, below {DRAW_SPREAD}"
        )
    if pattern > limit:
        found.append(f"checkerboard: a pattern of {pattern:.2f} grey levels, above {limit:.2f}")
    return found


def _cut(scene, height, width):
    """The upper left of a scene."""
    image = scene.image[:height, :width]
    layer_bins = scene.layer_bins[:, :width]
    return replace(scene, n_range_bins=height, layer_bins=layer_bins, image=image)


def _root_mean_square(values):
    return float(np.sqrt(np.mean(values**2)))


def _difference(images):
    """Root mean square difference between images (image, row, column), over all pairs."""
    # The mean square over pairs is twice the variance over images times n / (n - 1).
    variance = np.var(images, axis=0, ddof=1)
    return float(np.sqrt(2 * np.mean(variance)))
