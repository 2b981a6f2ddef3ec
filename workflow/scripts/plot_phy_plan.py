"""What the plans of all label scenes left out, as histograms."""

from job import job

from lib.figures.phy import plot_plans
from lib.figures.style import new_figure, note_source, write_figure
from snowsim.io.files import read_table


def plot(path_to_plans, path_to_figure, source):
    plans = read_table(path_to_plans)
    figure, axes = new_figure(1, 3, width=8, height=2.6)
    plot_plans(axes[0, 0], plans, "plan_share", "share of pixels times layers computed")
    plot_plans(axes[0, 1], plans, "plan_cost_normals", "predicted cost [normals per pixel]")
    tolerance_db = plans["plan_tolerance_db"].iloc[0]
    plot_plans(axes[0, 2], plans, "plan_bound_db", "error bound [dB]", ("tolerance", tolerance_db))
    note_source(figure, source)
    write_figure(path_to_figure, figure)


if __name__ == "__main__":
    with job(snakemake):
        plot(snakemake.input.plans, *snakemake.output, **snakemake.params)
