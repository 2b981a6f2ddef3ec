"""Accuracy of the convolution model: errors against a coherent one, of waveforms, and cost."""

from functools import partial

from main_path import run

from evaluation.lib.convolution_charts import convolution_table
from snowsim.io.files import write_table
from snowsim.reference import checked_settings, draw_climate
from snowsim.seeding import random_stream


def measure_convolution(table, *, reference, n_looks, seed, source):
    settings = checked_settings(reference)
    climate = draw_climate(settings, rng=random_stream(seed, "climate"))
    stream = partial(random_stream, seed, "measure_convolution")
    found = convolution_table(settings, climate, n_looks, stream)
    write_table(table, found.assign(data=source))


run(measure_convolution)
