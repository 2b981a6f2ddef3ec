"""Render one shard of scenes with PHY."""

from job import job, progress

from lib.phy_renders import render_by_phy
from snowsim.io.files import read_dataset
from snowsim.io.scenes import SceneSet, write_scenes
from snowsim.seeding import random_stream

with job(snakemake):
    flight = read_dataset(snakemake.input.statistics)

    def rendered(scene):
        """The scene with its image."""
        # By scene, never by shard: how scenes are divided must not change them.
        rng = random_stream(snakemake.params.seed, "render_phy", scene.name)
        return render_by_phy(scene, flight, snakemake.params.phy, rng=rng)

    attributes = {"method": "PHY", "synthetic": flight.attrs["synthetic"]}
    with SceneSet(snakemake.input.layers) as drawn:
        write_scenes(snakemake.output.scenes, map(rendered, progress(drawn, "PHY")), attributes)
