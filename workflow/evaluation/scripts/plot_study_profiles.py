"""Figure of the study of profiles."""

from main_path import run

from evaluation.lib.figures import study_profiles
from evaluation.lib.figures.style import save_figure
from snowsim.io.files import read_table


def plot_study_profiles(profiles, atlas_profiles_svg, source):
    save_figure(atlas_profiles_svg, study_profiles.atlas_profiles(read_table(profiles)), source)


run(plot_study_profiles)
