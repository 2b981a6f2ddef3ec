"""Scores on test scenes of a tracker of someone's own, as `snowsim score` gives them."""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from job import job, progress

from lib.own_functions import own_function
from snowsim.io.files import write_table
from snowsim.io.scenes import SceneSet
from snowsim.scoring import score_folders

with job(snakemake) as log, TemporaryDirectory() as folder:
    tracker = own_function(snakemake.input.function, snakemake.params.tracker)
    maps, truth = Path(folder, "maps"), Path(folder, "truth")
    maps.mkdir()
    truth.mkdir()
    with SceneSet(snakemake.input.scenes) as scenes:
        for scene in progress(scenes, snakemake.params.tracker):
            np.save(maps / f"{scene.name}.npy", tracker(scene.image))
            np.save(truth / f"{scene.name}.npy", scene.mask())
    options = {name: snakemake.params[name] for name in ("seed", "n_bootstrap")}
    table = score_folders(maps, truth, **options)
    for note in table.attrs["notes"]:
        log.info(note)
    write_table(snakemake.output.table, table)
