"""Milliseconds a training step takes on a GPU: called, captured, and by arithmetic alone.

``python benchmarks/bench_gpu.py [--published FOLDER]`` takes about 90 s on a GPU and needs no data.
It draws 60 scenes of 256 range lines and 22 heights from 300 range bins on, trains each network on
them with eight threads that prepare inputs, and prints a table, and the hours of the trainings of
`config/paper.yaml`. The floor is the number of products by the rate of a large matrix product on
the same card. Without a GPU everything runs at a toy size and nothing is captured. FOLDER holds
github.com/BinaLab/MultiScale, whose gradient is then timed beside, without loading of data.
"""

import argparse
import sys
import time
from dataclasses import replace
from itertools import islice

import numpy as np
import pandas as pd
import torch
from torch.utils.benchmark import Timer
from torch.utils.flop_counter import FlopCounterMode

import snowsim.training
from snowsim import cgan, tracker
from snowsim.echogram import Scene
from snowsim.settings import CGAN

N_SCENES, N_HEIGHTS, FIRST_HEIGHT, HEIGHT_STEP, N_LINES = 60, 22, 300, 24, 256
N_WORKERS = 7
# Gradients of the four training sets and steps of the cGAN, config/paper.yaml.
N_TRACKER, N_CGAN = 177_000 + 2 * 289_500 + 402_000, 472_000
PIX2PIX = replace(CGAN["paper"], width=64)
TRAININGS = {
    "tracker published, width 64": tracker.published_settings(width=64),
    "cGAN paper, width 64": PIX2PIX,
    "cGAN measured, width 64": cgan.Settings(width=64, depth=8),
    "tracker small, width 8": tracker.Settings(width=8, n_range_lines=256),
}


def draw_scenes():
    """Scenes of all heights, 10 level layers in speckle."""
    rng = np.random.default_rng(1)
    scenes = []
    for number in range(N_SCENES):
        height = FIRST_HEIGHT + HEIGHT_STEP * (number % N_HEIGHTS)
        layer_bins = np.linspace(50, height - 100, 10)[:, None] + np.zeros(N_LINES)
        image = np.uint8(rng.gamma(5, 12, (height, N_LINES)).clip(0, 200))
        scene = Scene(f"scene {number}", height, layer_bins, image)
        image[scene.mask()] = 255
        scenes.append(scene)
    return scenes


def toy(settings):
    """Settings of a size for which a processor will do."""
    if isinstance(settings, tracker.Settings):
        return replace(settings, width=2, n_accumulated=2)
    if settings.method == "pix2pix":
        return replace(settings, width=2, depth=5, n_range_bins=64, n_range_lines=64)
    return replace(settings, width=2, depth=4, n_range_bins=64, n_range_lines=64)


def begun(settings, scenes, device, n_workers):
    """A training and its steps."""
    if isinstance(settings, cgan.Settings):
        training = cgan.Training(settings, seed=1, device=device)
        return cgan.train_steps(training, scenes, n_workers=n_workers)
    training = tracker.Training(settings, seed=1, device=device)
    shown = tracker.TrainingSet(scenes, seed=1)
    return tracker.train_steps(training, shown, n_workers=n_workers)


def step_ms(settings, scenes, device, n_first, n_timed, n_graphs):
    """Milliseconds of a step: of `n_timed` after `n_first`; and of the first ones."""
    snowsim.training.MOST_GRAPHS = n_graphs
    n_workers = N_WORKERS if device == "cuda" else 0
    settings = replace(settings, n_steps=n_first + n_timed)
    times = [time.perf_counter()]
    numbers = [0]
    for step, _ in begun(settings, scenes, device, n_workers):
        times.append(time.perf_counter())
        numbers.append(step)
    split = np.searchsorted(numbers, n_first)
    before = (times[split] - times[0]) / numbers[split]
    after = (times[-1] - times[split]) / (numbers[-1] - numbers[split])
    return 1e3 * after, 1e3 * before


def n_products(settings, scenes):
    """Floating-point operations of a step, the mean of four."""
    n_steps = 4
    with FlopCounterMode(display=False) as counter:
        list(islice(begun(settings, scenes, "cpu", 0), n_steps))
    return counter.get_total_flops() / n_steps


def matrix_rates(device, n):
    """Floating-point operations a second of products of large matrices, by precision."""
    # As convolutions of float32 do on a GPU.
    torch.backends.cuda.matmul.allow_tf32 = True
    rates = {}
    for name in ("float32", "bfloat16"):
        a = torch.randn(n, n, device=device, dtype=getattr(torch, name))
        product = Timer("a @ a", globals={"a": a})
        rates[name] = 2 * n**3 / product.timeit(10).mean
    torch.backends.cuda.matmul.allow_tf32 = False
    return rates


def published_ms(folder, scenes, device, n_steps):
    """Milliseconds of a gradient by the published code."""
    sys.path.insert(0, folder)
    from modules.functions import cross_entropy_loss
    from msnet import msNet

    network = msNet().to(device)
    start = time.perf_counter()
    for step in range(n_steps):
        scene = scenes[step % len(scenes)]
        image = torch.from_numpy(scene.image.astype(np.float32))[None, None].to(device)
        label = torch.from_numpy(scene.mask())[None, None].to(device)
        losses = [cross_entropy_loss(output, label) for output in network({"image": image})]
        (sum(losses) / 10).backward()
        sum(losses).item()
    return 1e3 * (time.perf_counter() - start) / n_steps


def measure(chosen, scenes, rates, n_graphs):
    """Milliseconds of a step, captured and called, each beside that of its first; and the floor."""
    if torch.cuda.is_available():
        # Every height is met at every scale in the first steps.
        device, settings, n_first, n_timed = "cuda", chosen, 600, 1000
    else:
        device, settings, n_first, n_timed = "cpu", toy(chosen), 2, 4
    captured = step_ms(settings, scenes, device, n_first, n_timed, n_graphs)
    called = step_ms(settings, scenes, device, n_first // 2, n_timed // 4, 0)
    floor_ms = 1e3 * n_products(settings, scenes) / rates[settings.precision]
    return [*captured, *called, floor_ms]


def main():
    """Print the table."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--published", metavar="FOLDER")
    folder = options.parse_args().published
    torch.set_num_threads(1)
    is_gpu = torch.cuda.is_available()
    device = "cuda" if is_gpu else "cpu"
    n_graphs = snowsim.training.MOST_GRAPHS
    scenes = draw_scenes()
    rates = matrix_rates(device, 8192 if is_gpu else 256)
    columns = ["captured", "its first", "called", "its first", "floor"]
    rows = {name: measure(chosen, scenes, rates, n_graphs) for name, chosen in TRAININGS.items()}
    table = pd.DataFrame.from_dict(rows, orient="index", columns=columns)
    lines = [f"{torch.cuda.get_device_name() if is_gpu else 'a processor, toy sizes'}, ms a step"]
    lines += [table.to_string(float_format="%.2f")]
    if is_gpu:
        of_tracker, printed, measured = table["captured"].iloc[:3]
        alone, after = (N_TRACKER * of_tracker + N_CGAN * np.array([measured, printed])) / 3.6e6
        lines.append(f"trainings of config/paper.yaml: {alone:.2f} h")
        lines.append(f"trainings of it after config/as_printed.yaml: {after:.2f} h")
        lines.append(f"largest memory {torch.cuda.max_memory_allocated() / 2**30:.1f} GiB")
    if folder is not None:
        ms = published_ms(folder, scenes, device, 600 if is_gpu else 1)
        lines.append(f"published code, data in memory: {ms:.2f} ms a gradient")
    sys.stdout.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
