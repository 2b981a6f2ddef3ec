"""Figure of the budgets of all trainings."""

from main_path import run

from evaluation.lib.figures import study_budgets
from evaluation.lib.figures.style import save_figure
from snowsim.io.files import read_table


def plot_study_budgets(tracker, cgan, budgets_svg, source):
    save_figure(budgets_svg, study_budgets.budgets(read_table(tracker), read_table(cgan)), source)


run(plot_study_budgets)
