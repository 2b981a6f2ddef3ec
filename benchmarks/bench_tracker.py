"""Cost of training the tracker.

Against a plain PyTorch loop and the arithmetic alone, and at the paper's scale.

``python benchmarks/bench_tracker.py`` times steps of this package and of a plain loop in turn
(eager, float32, contiguous layout, AdamW as it comes, loss and fusion as usually written) on the
same scenes, and a product of matrices with as many multiplications as a step's convolutions. It
prints the ratios and fails where the package is slower.

``python benchmarks/bench_tracker.py RESULTS`` takes an epoch of two real scenes, of two label
scenes and of the highest label scene (10 gradients and an update each) by the published recipe, on
a GPU where there is one. It prints seconds a megapixel and the peak of memory, and what the four
trainings would take by their gradients and mean heights.

Both need the folder ``workflow`` on ``PYTHONPATH``, as ``make benchmarks`` sets it.
"""

import logging
import resource
import sys
import time
from pathlib import Path

import numpy as np
import torch
import yaml
from bench_cgan import draw_scene
from torch.nn import functional

from evaluation.lib.machine import time_rounds
from snowsim.io.scenes import SceneSet
from snowsim.patches import draw_patches
from snowsim.seeding import random_stream
from snowsim.tracker import Settings, Training, TrainingSet, published, train_steps
from snowsim.tracker.network import MultiScaleNetwork
from snowsim.tracker.train import rate_factor

CONFIG = Path(__file__).parents[1] / "config"
N_REAL, N_ADDED = 2360, {"rd": 0, "rd_gd": 1500, "rd_pd": 1500, "rd_pd_gd": 3000}
N_EPOCH_COPIES = 5
N_ROUNDS, N_STEPS, SEED = 7, 20, 1

log = logging.getLogger(__name__)


class PlainNetwork(MultiScaleNetwork):
    """The network with its fusion as a convolution of joined maps."""

    def forward(self, image):
        x, sides = image, []
        for number, (stage, side) in enumerate(zip(self.stages, self.sides, strict=True)):
            x = functional.max_pool2d(x, 2, ceil_mode=True) if number else x
            for convolution in stage:
                x = functional.relu(convolution(x))
            sides.append(self.enlarged(side(x), (2**number, 2**number), image.shape[2:]))
        return torch.stack([*sides, self.fuse(torch.cat(sides, dim=1))])


def plain_steps(settings, scenes):
    """The same training as anyone would write it down.

    Draws, losses and schedule as in the package.
    """
    network = PlainNetwork(settings.width)
    network.initialise(rng=random_stream(SEED, "tracker", "network"))
    optimiser = torch.optim.AdamW(
        network.parameters(), lr=settings.learning_rate, weight_decay=settings.weight_decay
    )
    for step in range(settings.n_steps):
        rng = random_stream(SEED, "tracker", "step", step)
        batch = [
            scenes[step * settings.batch_size + number] for number in range(settings.batch_size)
        ]
        images, masks = draw_patches(batch, settings.n_range_bins, settings.n_range_lines, rng=rng)
        layer = torch.from_numpy(masks)[:, None].float()
        logits = network(network.to_input(images))
        weight = torch.where(layer > 0, 1 - settings.layer_share, settings.layer_share)
        losses = (
            functional.binary_cross_entropy_with_logits(
                logits, layer.expand_as(logits), reduction="none"
            )
            * weight
        )
        loss = losses.mean(dim=(1, 2, 3, 4)).sum()
        for group in optimiser.param_groups:
            group["lr"] = settings.learning_rate * rate_factor(settings, step)
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        yield step + 1, {"total": loss.item()}


def n_products(settings):
    """Multiplications of the convolutions of a step: forward, and twice as many backward."""
    counted = []
    network = MultiScaleNetwork(settings.width)
    for layer in network.modules():
        if isinstance(layer, torch.nn.Conv2d) and layer.kernel_size == (3, 3):
            layer.register_forward_hook(
                lambda layer, given, out: counted.append(out.numel() * layer.weight[0].numel())
            )
    network(torch.zeros(settings.batch_size, 1, settings.n_range_bins, settings.n_range_lines))
    return 3 * sum(counted)


def compare(settings):
    """Ratio of a plain step's cost to the package's, beside a step as one product of matrices."""
    scenes = TrainingSet([draw_scene(number, 300) for number in range(8)], seed=SEED)
    steps = {
        "package": train_steps(Training(settings, seed=SEED), scenes),
        "plain": plain_steps(settings, scenes),
    }
    size = round(n_products(settings) ** (1 / 3))
    square = torch.randn(size, size).to(getattr(torch, settings.precision))
    works = {
        name: lambda taken=taken: [next(taken) for _ in range(N_STEPS)]
        for name, taken in steps.items()
    }
    works["product"] = lambda: [square @ square for _ in range(N_STEPS)]
    # Processor time: other work on the machine does not count.
    runs = time_rounds(works, N_ROUNDS, clock=time.process_time)
    cost = {name: np.median([s for run, _, s in runs if run == name]) / N_STEPS for name in works}
    log.info("width %d: %.1f ms a step", settings.width, 1e3 * cost["package"])
    ratio = {name: cost[name] / cost["package"] for name in cost}
    log.info("plain %.1f ms (ratio %.2f)", 1e3 * cost["plain"], ratio["plain"])
    log.info("its arithmetic %.1f ms (ratio %.2f)", 1e3 * cost["product"], ratio["product"])
    return ratio["plain"]


def paper_settings():
    """Settings and epochs of config/paper.yaml; steps for one epoch of two scenes."""
    paper = yaml.safe_load((CONFIG / "paper.yaml").read_text())["tracker"]
    return published(n_steps=2 * N_EPOCH_COPIES), paper["n_epochs"]


def time_epoch(name, scenes, settings, device):
    """Seconds a megapixel of an epoch of two scenes."""
    training = Training(settings, seed=1, device=device)
    # On the CPU processor time: other work on the machine does not count.
    clock = time.perf_counter if device == "cuda" else time.process_time
    start = clock()
    for _ in train_steps(
        training, TrainingSet(scenes, seed=1)
    ):  # reading the losses waits for the device
        pass
    seconds = clock() - start
    if device == "cuda":
        peak = torch.cuda.max_memory_allocated() / 1e9
    else:
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    megapixels = copied_megapixels(sum(scene.n_range_bins for scene in scenes), settings)
    heights = " and ".join(str(scene.n_range_bins) for scene in scenes)
    log.info("%s of %s rows: %.2f s a gradient, %.2f s a megapixel, peak %.2f GB",
             name, heights, seconds / settings.n_steps, seconds / megapixels, peak)  # fmt: skip
    return seconds / megapixels


def copied_megapixels(n_rows, settings):
    """Pixels of all copies of so many rows of 256 range lines."""
    return n_rows * 256e-6 * (sum(scale**2 for scale in settings.scales) + settings.flip)


def project(results):
    settings, n_epochs = paper_settings()
    device = "cuda" if torch.cuda.is_available() else "cpu"
    log.info(
        "width %d, %s, %s, %d threads",
        settings.width,
        settings.precision,
        device,
        torch.get_num_threads(),
    )
    files = {"real": "benchmark/train", "label": "phy/labels"}
    costs, mean_rows = {}, {}
    for kind, folder in files.items():
        with SceneSet(sorted(Path(results, folder).glob("*.nc"))) as scenes:
            rows = np.array([scene.n_range_bins for scene in scenes])
            order = np.argsort(rows)
            mean_rows[kind] = rows.mean()
            middle = [scenes[order[int(share * len(rows))]] for share in (0.25, 0.75)]
            costs[kind] = time_epoch(f"{kind} scenes", middle, settings, device)
            highest = [scenes[order[-1]]] * 2
    time_epoch("highest label scene, twice", highest, settings, device)
    for name, n_added in N_ADDED.items():
        n_gradients = n_epochs * N_EPOCH_COPIES * (N_REAL + n_added)
        seconds = sum(
            n_epochs * n * copied_megapixels(mean_rows[kind], settings) * costs[kind]
            for kind, n in (("real", N_REAL), ("label", n_added))
        )
        log.info(
            "%-8s %d gradients, %d updates, %.1f days",
            name,
            n_gradients,
            n_gradients // 10,
            seconds / 86400,
        )


if __name__ == "__main__":
    logging.basicConfig(level=logging.INFO, format="%(message)s", stream=sys.stdout)
    torch.set_num_threads(1)
    if len(sys.argv) > 1:
        project(sys.argv[1])
    else:
        if compare(Settings(n_steps=10**9)) < 1:
            sys.exit("a step is slower than a plain loop's")
