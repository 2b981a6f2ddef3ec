"""Draw one shard of synthetic layer sets from the flight statistics."""

from job import run

from lib.label_sets import draw_shard


def draw_labels(statistics, labels, **settings):
    draw_shard(statistics, labels, **settings)


run(draw_labels)
