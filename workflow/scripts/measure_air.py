"""Texture above the snow surface, observed and rendered."""

import pandas as pd
from job import job

from lib.diagnostics.renders import air_texture
from snowsim.io.files import write_table
from snowsim.io.scenes import SceneSet


def measure(paths_by_method, path_to_table):
    rows = []
    for method, paths in paths_by_method.items():
        with SceneSet(paths) as scenes:
            for scene in scenes:
                texture = air_texture(scene.image, scene.layer_bins)
                rows += [{"method": method, "quantity": name, "value": value} for name, value in texture.items()]
    groups = pd.DataFrame(rows).groupby(["quantity", "method"], sort=False)["value"]
    write_table(path_to_table, groups.agg(["min", "mean", "max"]).assign(n_scenes=groups.size()).reset_index())


if __name__ == "__main__":
    with job(snakemake):
        measure({method: snakemake.input[method] for method in ("observed", "cgan", "phy")}, snakemake.output.table)
