"""Figures of similarity."""

from main_path import job

from evaluation.lib.figures import similarity
from evaluation.lib.figures.style import Scale, save_figure
from snowsim.io.files import read_dataset, read_table

with job(snakemake):
    params = snakemake.params
    boxplots = similarity.similarity_boxplots(read_table(snakemake.input.images))
    save_figure(snakemake.output.similarity_boxplots_svg, boxplots, params.source)
    scale = Scale.of(read_dataset(snakemake.input.statistics), params.snow_density_kg_m3)
    by_depth = similarity.ssim_depth(read_table(snakemake.input.ssim_depth), scale)
    save_figure(snakemake.output.ssim_depth_svg, by_depth, params.source)
