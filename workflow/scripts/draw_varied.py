"""Scenes of some variants of the flight's statistics, other climates and radars, by PHY."""

from job import progress, run

from lib.pretraining import varied_scenes
from snowsim.io.files import read_dataset
from snowsim.io.scenes import write_scenes


def draw_varied(statistics, scenes, *, variants, n_scenes, n_range_lines, phy, seed):
    flight = read_dataset(statistics)
    attributes = {"method": "PHY", "synthetic": flight.attrs["synthetic"]}
    drawn = varied_scenes(
        flight, range(*variants), n_scenes, n_range_lines=n_range_lines, phy=phy, seed=seed
    )
    n_drawn = n_scenes * len(range(*variants))
    write_scenes(scenes, progress(drawn, "varied scenes", total=n_drawn), attributes)


run(draw_varied)
