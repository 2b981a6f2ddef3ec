"""Cost of training the conditional GAN: against a plain PyTorch loop, and at the paper's scale.

``python benchmarks/bench_cgan.py`` times steps of this package and of a plain loop in turn (eager,
float32, contiguous layout, Adam as it comes) on the same scenes, trains both for as many steps from
the same weights and prints the ratio of their cost beside their losses. It fails where the package
is slower.

``python benchmarks/bench_cgan.py --paper [SECONDS]`` runs a slice of that many seconds (60 unless
told) of the training that config/paper.yaml asks for, on a GPU where there is one, and prints what
the whole would take.

Both need the folder ``workflow`` on ``PYTHONPATH``, as ``make benchmarks`` sets it.
"""

import dataclasses
import logging
import sys
import time
from pathlib import Path

import numpy as np
import torch
import yaml
from torch.nn import functional

from evaluation.lib.machine import time_rounds
from snowsim.cgan import Settings, Training, train_steps
from snowsim.cgan.published import draw_batch
from snowsim.cgan.train import learning_rate
from snowsim.echogram import Scene
from snowsim.seeding import random_stream

CONFIG = Path(__file__).parents[1] / "config"
N_ROUNDS = 5
N_TRAINED = 60  # steps of both, for their losses
SEED = 1

log = logging.getLogger(__name__)


def draw_scene(number, n_range_bins, n_range_lines=256, n_layers=8):
    """A scene of wavy layers with tails, 16 looks."""
    rng = random_stream(SEED, "bench_cgan", number)
    wave = 3 * np.sin(2 * np.pi * (np.arange(n_range_lines) / n_range_lines + rng.random()))
    layer_bins = 50 + np.arange(n_layers)[:, None] * rng.uniform(15, 25) + wave
    below = np.arange(n_range_bins)[:, None] - layer_bins[:, None]
    strength = rng.uniform(0.3, 1, (n_layers, 1, 1))
    fall = np.where(below < 0, 4 * below**2, below / 12)
    level = 60 + 150 * (strength * np.exp(-fall)).max(axis=0)
    speckled = level * rng.gamma(16, 1 / 16, level.shape)
    image = np.minimum(np.rint(speckled), 255)
    return Scene(f"scene {number}", n_range_bins, layer_bins, image.astype(np.uint8))


def plain_steps(settings, scenes):
    """The same training as anyone would write it: draws, losses and schedule as in the package."""
    start = Training(settings, seed=SEED)
    networks = generator, discriminator = start.generator, start.discriminator
    adams = []
    for network in networks:
        network.to(memory_format=torch.contiguous_format)
        betas = (settings.beta1, settings.beta2)
        adams.append(torch.optim.Adam(network.parameters(), lr=settings.learning_rate, betas=betas))
    bce = functional.binary_cross_entropy_with_logits
    for step in range(settings.n_steps):
        rng = random_stream(SEED, "cgan", "step", step)
        batch = draw_batch(generator, scenes.__getitem__, len(scenes), settings, rng=rng)
        mask, image = batch.inputs, batch.image
        for adam in adams:
            for group in adam.param_groups:
                group["lr"] = learning_rate(settings, step)
        fake = generator(mask, batch.noise)
        on_real, on_fake = discriminator(mask, image), discriminator(mask, fake.detach())
        both = bce(on_real, torch.ones_like(on_real)) + bce(on_fake, torch.zeros_like(on_fake))
        adams[1].zero_grad()
        both.backward()
        adams[1].step()
        decision = discriminator(mask, fake)
        l1 = functional.l1_loss(fake, image)
        adams[0].zero_grad()
        (bce(decision, torch.ones_like(decision)) + settings.l1_weight * l1).backward()
        adams[0].step()
        yield step + 1, {"l1": l1.item(), "discriminator": both.item() / 2}


def package_steps(settings, scenes):
    for step, losses in train_steps(Training(settings, seed=SEED), scenes):
        of_discriminator = (losses["discriminator_real"] + losses["discriminator_fake"]) / 2
        yield step, {"l1": losses["l1"], "discriminator": of_discriminator}


def compare(settings):
    """Ratio of a plain step's cost to the package's."""
    scenes = [
        draw_scene(number, n_range_bins)
        for number, n_range_bins in enumerate((300, 300, 300, 400, 520))
    ]
    loops = {"package": package_steps, "plain": plain_steps}
    for name, loop in loops.items():
        trained = dataclasses.replace(
            settings, n_steps=N_TRAINED, precision=precision_of(name, settings)
        )
        late = [losses for _, losses in loop(trained, scenes)][-N_TRAINED // 3 :]
        means = {key: np.mean([losses[key] for losses in late]) for key in late[0]}
        log.info(
            "%-8s %s after %d steps",
            name,
            {k: round(float(v), 4) for k, v in means.items()},
            N_TRAINED,
        )
    works = {}
    for name, loop in loops.items():
        endless = dataclasses.replace(
            settings, n_steps=10**9, precision=precision_of(name, settings)
        )
        steps = loop(endless, scenes)
        works[name] = lambda steps=steps: [next(steps) for _ in scenes]
    # Processor time: other work on the machine does not count.
    runs = time_rounds(works, N_ROUNDS, clock=time.process_time)
    seconds = {name: [] for name in works}
    for name, _, spent in runs:
        seconds[name].append(spent)
    cost = {name: np.median(spent) / len(scenes) for name, spent in seconds.items()}
    ratios = np.array(seconds["plain"]) / np.array(seconds["package"])
    low, high = np.percentile(ratios, [25, 75])
    log.info(
        "width %d: package %.1f ms a step, plain %.1f ms; plain / package %.2f (%.2f to %.2f)",
        settings.width,
        1e3 * cost["package"],
        1e3 * cost["plain"],
        np.median(ratios),
        low,
        high,
    )
    return float(np.median(ratios))


def precision_of(name, settings):
    return "float32" if name == "plain" else settings.precision


def project_paper(seconds):
    """Time a slice of the paper-scale training; the whole is its mean step times their number."""
    paper = yaml.safe_load((CONFIG / "paper.yaml").read_text())["cgan"]["training"]
    settings = Settings(**paper)
    device = "cuda" if torch.cuda.is_available() else "cpu"
    # Heights as the benchmark has them: half of the scenes 300 rows, the others up to 750.
    scenes = [
        draw_scene(number, height)
        for number, height in enumerate((300, 300, 300, 300, 330, 400, 500, 700))
    ]
    steps = train_steps(Training(settings, seed=SEED, device=device), scenes)
    for _ in scenes:  # one of every height to warm up
        next(steps)
    # On the CPU processor time: other work on the machine does not count.
    clock = time.perf_counter if device == "cuda" else time.process_time
    n_steps, start = 0, clock()
    while clock() - start < seconds or n_steps % len(scenes):
        next(steps)  # reading the losses waits for the device
        n_steps += 1
    per_step = (clock() - start) / n_steps
    hours = per_step * settings.n_steps / 3600
    log.info(
        "width %d, %s, %s: %d steps, %.3f s a step; %d steps would take %.1f h",
        settings.width,
        settings.precision,
        device,
        n_steps,
        per_step,
        settings.n_steps,
        hours,
    )


if __name__ == "__main__":
    logging.basicConfig(level=logging.INFO, format="%(message)s", stream=sys.stdout)
    torch.set_num_threads(1)
    if "--paper" in sys.argv:
        given = sys.argv[sys.argv.index("--paper") + 1 :]
        project_paper(float(given[0]) if given else 60.0)
    elif compare(Settings(method="pix2pix", n_range_lines=256, width=16, depth=8, dropout=0.5)) < 1:
        sys.exit("a step is slower than a plain loop's")
