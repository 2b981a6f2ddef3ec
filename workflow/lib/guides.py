"""Label sets as PHY renders them, kept in parts that a guided generator corrects."""

from snowsim.cgan import guide_of
from snowsim.phy import mean_field, plan, render_plan, scene_parameters
from snowsim.seeding import random_stream


class Guides:
    """A sequence of guides of label sets, each made when asked for: uncorrected they are PHY's renders to the byte.

    `phy` are options of `snowsim.phy.render.render_scene`.
    """

    def __init__(self, label_sets, statistics, phy, *, seed):
        self.label_sets, self.statistics, self.phy, self.seed = label_sets, statistics, dict(phy), seed

    def __len__(self):
        return len(self.label_sets)

    def __getitem__(self, item):
        return self.of(self.label_sets[item])

    def of(self, scene):
        """The guide of a scene."""
        rng = random_stream(self.seed, "render_phy", scene.name)
        of_render = {key: self.phy[key] for key in ("tolerance_db", "speckle", "normalise", "align") if key in self.phy}
        drawn = {key: value for key, value in self.phy.items() if key not in of_render}
        layer_bins, parameters = scene_parameters(scene, self.statistics, **drawn, rng=rng)
        planned = plan(layer_bins, parameters, scene.n_range_bins, **of_render)
        mean = mean_field(planned, rng=rng)
        return guide_of(scene, mean, render_plan(planned, rng=rng, mean=mean.copy()))
