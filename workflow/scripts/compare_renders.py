"""Where layers lie in renders of the test masks, and their texture above and below the surface."""

import pandas as pd
from job import job, progress

from lib.diagnostics.renders import position_errors, shape_edges, texture_by_region
from snowsim.io.files import write_table
from snowsim.io.scenes import SceneSet


def compare(paths_to_observed, paths_to_cgan, paths_to_phy, path_to_positions, path_to_textures):
    with SceneSet(paths_to_observed) as observed_scenes:
        edges = shape_edges(scene.layer_bins for scene in observed_scenes)
    positions, textures = [], []
    for method, paths in (("observed", paths_to_observed), ("cgan", paths_to_cgan), ("phy", paths_to_phy)):
        with SceneSet(paths_to_observed) as observed_scenes, SceneSet(paths) as scenes:
            pairs = zip(observed_scenes, scenes, strict=True)
            for observed, scene in progress(pairs, f"{method} scenes", total=len(scenes)):
                if observed.name != scene.name:
                    msg = f"{method}: expected scene {observed.name}, got {scene.name}"
                    raise ValueError(msg)
                keys = {"scene": scene.name, "method": method}
                # Renders were given the annotated layers: these are where their peaks should lie.
                positions.append(position_errors(scene.image, observed.layer_bins, edges).assign(**keys))
                textures.append(texture_by_region(scene.image, observed.image, observed.layer_bins).assign(**keys))
    for path, tables in ((path_to_positions, positions), (path_to_textures, textures)):
        table = pd.concat(tables)
        write_table(path, table[["scene", "method", *table.columns.drop(["scene", "method"])]])


if __name__ == "__main__":
    with job(snakemake):
        compare(snakemake.input.observed, snakemake.input.cgan, snakemake.input.phy, *snakemake.output)
