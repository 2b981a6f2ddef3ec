"""Draw one shard of label sets from the statistics of a few scenes, as these permit."""

from main_path import run

from lib.label_sets import draw_shard
from snowsim.io.files import read_table


def draw_few(statistics, choice, labels, *, settings, span, seed):
    (radiometry,) = read_table(choice)["radiometry"]
    settings = settings | {"radiometry": radiometry}
    draw_shard(statistics, labels, span=span, seed=seed, **settings)


run(draw_few)
