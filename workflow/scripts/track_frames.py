"""Layers of some own frames by a trained tracker, and a table of the frames with their layers."""

from pathlib import Path

import numpy as np
import pandas as pd
from job import job, progress

from snowsim.io.files import read_dataset, write_table
from snowsim.tracking import track_files


def picked(path):
    """Layers below the surface and picks of them in a file of layers; none where it is missing."""
    if not path.exists():
        return {"tracked": False, "n_layers": 0, "n_picks": 0}
    twtt = read_dataset(path)["twtt"].values[1:]
    return {"tracked": True, "n_layers": len(twtt), "n_picks": int(np.isfinite(twtt).sum())}


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
    rows = []
    for frame, echogram in zip(snakemake.params.frames, echograms, strict=True):
        found = folder / f"{Path(echogram).stem}_layers.nc"
        lines = [line for line in said if str(echogram) in line]
        rows.append({"frame": frame, **picked(found), "remarks": "; ".join(lines)})
    for line in said:
        log.info(line)
    write_table(snakemake.output.table, pd.DataFrame(rows))
