"""Frames of the synthetic reference flight; one shard also has its complex segment."""

from job import progress, run

from snowsim.io.files import write_dataset
from snowsim.reference import checked_settings, draw_climate, draw_complex_segment, draw_frame
from snowsim.seeding import random_stream


def draw_frames(echograms, layers, segment, *, frames, flight, reference, seed):
    settings = checked_settings(reference)
    climate = draw_climate(settings, rng=random_stream(seed, "climate"))
    files = zip(frames, echograms, layers, strict=True)
    for frame, path_to_echogram, path_to_layers in progress(files, "frames", total=len(frames)):
        rng = random_stream(seed, "reference_frame", frame)
        echogram, picked = draw_frame(frame, **flight, climate=climate, settings=settings, rng=rng)
        write_dataset(path_to_echogram, echogram)
        write_dataset(path_to_layers, picked)
    for path in segment:
        rng = random_stream(seed, "reference_segment")
        drawn = draw_complex_segment(climate=climate, settings=settings, rng=rng)
        write_dataset(path, drawn)


run(draw_frames)
