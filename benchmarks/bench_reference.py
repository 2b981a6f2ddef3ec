"""Seconds of the reference flight, whether they grow in proportion, and those of the paper's size.

One process and one thread, CPU seconds, so that other work on the machine counts little: python
benchmarks/bench_reference.py. Frames and scenes are independent, so N cores take an Nth of the
sums.
"""

import sys
import time
from pathlib import Path

import yaml

from snowsim.reference import checked_settings, draw_climate, draw_frame, draw_scene
from snowsim.seeding import random_stream

CONFIG = Path(__file__).resolve().parents[1] / "config"
FRAMES = (1, 2, 4)
LINES = (256, 512, 1024)
SPLITS = ("train", "validation", "test")


def cpu_seconds(work):
    start = time.process_time()
    work()
    return time.process_time() - start


say = sys.stdout.write


def merged(name):
    """Numbers of frames, lines and scenes of a configuration over the default."""
    default = yaml.safe_load((CONFIG / "config.yaml").read_text())
    override = yaml.safe_load((CONFIG / name).read_text())
    flight = default["flight"] | override.get("flight", {})
    scenes = default["benchmark"]["n_scenes"] | override.get("benchmark", {}).get("n_scenes", {})
    return flight["n_frames"], flight["n_range_lines"], sum(scenes.values())


def main():
    config = yaml.safe_load((CONFIG / "config.yaml").read_text())
    settings = checked_settings({})
    climate = draw_climate(settings, rng=random_stream(config["seed"], "climate"))
    n_looks = config["benchmark"]["n_looks"]
    shared = {"climate": climate, "settings": settings}

    def draw_frames(n_frames, n_lines):
        for frame in range(n_frames):
            draw_frame(frame, 20, n_lines, **shared, rng=random_stream(1, "frame", frame))

    def draw_scenes(split, n_scenes):
        for index in range(n_scenes):
            draw_scene(
                index, split, **shared, n_looks=n_looks, rng=random_stream(1, "scene", split, index)
            )

    draw_frames(1, 256)  # imports, caches
    n_lines = config["flight"]["n_range_lines"]
    say("frames       CPU s   per frame\n")
    for n_frames in FRAMES:
        seconds = cpu_seconds(lambda n=n_frames: draw_frames(n, n_lines))
        say(f"{n_frames:6d} {seconds:11.2f} {seconds / n_frames:11.3f}\n")
    per_frame = seconds / n_frames
    say("lines        CPU s   per 1000 lines\n")
    for lines in LINES:
        seconds = cpu_seconds(lambda n=lines: draw_frames(2, n)) / 2
        say(f"{lines:6d} {seconds:11.2f} {1e3 * seconds / lines:11.3f}\n")
    say("scenes       CPU s   per scene\n")
    per_scene = {}
    for split in SPLITS:
        seconds = cpu_seconds(lambda s=split: draw_scenes(s, 8))
        per_scene[split] = seconds / 8
        say(f"8 {split:10s} {seconds:5.2f} {per_scene[split]:11.3f}\n")
    report_sizes(per_frame / n_lines, sum(per_scene.values()) / len(SPLITS))


def report_sizes(seconds_a_line, seconds_a_scene):
    """What flight and benchmark of two configurations cost."""
    for name in ("config.yaml", "paper.yaml"):
        n_frames, lines, n_scenes = merged(name)
        flight_s = n_frames * lines * seconds_a_line
        scenes_s = n_scenes * seconds_a_scene
        minutes = (flight_s + scenes_s) / 60
        say(f"{name}: {n_frames * lines} lines {flight_s:.0f} CPU s, ")
        say(f"{n_scenes} scenes {scenes_s:.0f} CPU s; ")
        say(f"{minutes:.1f} CPU min, {minutes / 2:.1f} min on two cores\n")


if __name__ == "__main__":
    main()
