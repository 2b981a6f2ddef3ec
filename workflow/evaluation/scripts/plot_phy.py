"""Speed and accuracy of PHY, and what its plans leave out."""

from main_path import run

from evaluation.lib.figures import phy
from evaluation.lib.figures.style import save_figure
from snowsim.io.files import read_table


def plot_phy(
    speed_accuracy_waveforms,
    speed_accuracy_speckle,
    speed_accuracy_scenes,
    speed_accuracy_growth,
    plans,
    speed_accuracy_waveforms_svg,
    speed_accuracy_speckle_svg,
    speed_accuracy_scenes_svg,
    speed_accuracy_growth_svg,
    phy_plan_svg,
    source,
):
    save_figure(
        speed_accuracy_waveforms_svg,
        phy.speed_accuracy_waveforms(*map(read_table, speed_accuracy_waveforms)),
        source,
    )
    save_figure(
        speed_accuracy_speckle_svg,
        phy.speed_accuracy_speckle(*map(read_table, speed_accuracy_speckle)),
        source,
    )
    save_figure(
        speed_accuracy_scenes_svg,
        phy.speed_accuracy_scenes(*map(read_table, speed_accuracy_scenes)),
        source,
    )
    save_figure(
        speed_accuracy_growth_svg,
        phy.speed_accuracy_growth(*map(read_table, speed_accuracy_growth)),
        source,
    )
    save_figure(phy_plan_svg, phy.phy_plan(read_table(plans)), source)


run(plot_phy)
