"""Speed against accuracy of the task and of PHY, and where methods fail."""

from main_path import checkout_files, job

from evaluation.lib.figures import charts
from evaluation.lib.figures.style import PLANTED, save_figure
from snowsim.io.files import read_table

with job(snakemake):
    measured = read_table(snakemake.input.speed_accuracy)
    of_phy = read_table(snakemake.input.atlas_phy)
    of_statistics = read_table(snakemake.input.atlas_statistics)
    (left,) = checkout_files(snakemake.params.budgets)
    budgets = read_table(left)
    save_figure(snakemake.output.atlas_svg, charts.atlas(of_phy, of_statistics), PLANTED)
    commits = ", ".join(commit[:8] for commit in sorted(budgets["commit"].unique()))
    source = f"left: measured with snowsim at commits {commits}"
    chart = charts.speed_accuracy(budgets, measured)
    save_figure(snakemake.output.speed_accuracy_svg, chart, source)
