"""Worth of PHY's scenes by number of annotated ones: table and figure."""

import pandas as pd
from main_path import job

from evaluation.lib.annotation import annotation_curve
from evaluation.lib.figures.studies import annotation
from evaluation.lib.figures.style import save_figure
from snowsim.io.files import read_table, write_table

with job(snakemake):
    flights = zip(snakemake.input.scores, snakemake.params.flights, strict=True)
    scores = pd.concat([read_table(path).assign(flight=flight) for path, flight in flights])
    write_table(snakemake.output.scores, scores)
    curve = annotation_curve(scores)
    write_table(snakemake.output.curve, curve)
    figure = annotation(curve)
    save_figure(snakemake.output.annotation_svg, figure, snakemake.params.source)
