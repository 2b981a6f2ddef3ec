"""Frames of the synthetic reference flight; one shard also has its complex segment."""

from job import progress, run

from snowsim.io.files import write_dataset
from snowsim.reference import checked_settings, draw_climate, draw_complex_segment, draw_frame
from snowsim.seeding import random_stream


def draw_frames(echograms, layers, segment, *, frames, flight, reference, seed):
    settings = checked_settings(reference)
    climate = draw_climate(settings, rng=random_stream(seed, "climate"))
    made = {"climate": climate, "settings": settings}
    files = zip(frames, echograms, layers, strict=True)
    for frame, path_to_echogram, path_to_layers in progress(files, "frames", total=len(frames)):
        rng = random_stream(seed, "reference_frame", frame)
        echogram, picked = draw_frame(frame, **flight, **made, rng=rng)
        write_dataset(path_to_echogram, echogram)
        write_dataset(path_to_layers, picked)
    for path in segment:
        write_dataset(
            path, draw_complex_segment(**made, rng=random_stream(seed, "reference_segment"))
        )


run(draw_frames)
