"""Layers of some own frames by a trained tracker, and a table of the frames with their layers."""

from pathlib import Path

import pandas as pd
from job import job, progress

from snowsim.io.files import read_dataset, write_table
from snowsim.tracking import track_files

NOT_TRACKED = {"tracked": False, "n_layers": 0, "n_picks": 0}


def picked(path):
    """Numbers of layers below the surface and of their picks in a segment's file, by frame."""
    is_picked = read_dataset(path)["twtt"][1:].notnull()
    frames = {}
    for name, of_frame in is_picked.groupby("frame"):
        n_layers = int(of_frame.any("slow_time").sum())
        frames[name] = {"tracked": True, "n_layers": n_layers, "n_picks": int(of_frame.sum())}
    return frames


with job(snakemake) as log:
    echograms = snakemake.input.echograms
    folder = Path(snakemake.output.folder)
    # Also where no frame can be tracked.
    folder.mkdir()
    said = []
    track_files(
        echograms,
        folder,
        model=snakemake.params.model,
        say=said.append,
        progress=lambda total: progress(None, "frames", total),
    )
    found = {}
    for path in folder.glob("*_layers.nc"):
        found |= picked(path)
    rows = []
    for frame, echogram in zip(snakemake.params.frames, echograms, strict=True):
        lines = [line for line in said if str(echogram) in line]
        of_frame = found.get(Path(echogram).stem, NOT_TRACKED)
        rows.append({"frame": frame, **of_frame, "remarks": "; ".join(lines)})
    for line in said:
        log.info(line)
    write_table(folder / "frames.csv", pd.DataFrame(rows))
