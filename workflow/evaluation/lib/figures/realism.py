"""How near the flight comes to real Snow Radar: all quantities, curves, and crops side by side."""

import numpy as np

from evaluation.lib.figures.style import BLACK, BLUE, GUIDE, RED, new_figure

CURVES = {
    "Greenland, autocorrelation along track": {
        "xlabel": "distance [m]",
        "ylabel": "autocorrelation, 100 m means",
    },
    "snow, autocorrelation along track": {
        "xlabel": "distance [range lines]",
        "ylabel": "autocorrelation, homogeneous snow",
    },
    "air, autocorrelation down": {
        "xlabel": "delay [ns]",
        "ylabel": "autocorrelation, air",
    },
    "Greenland, shift of layers": {
        "xlabel": "distance [m]",
        "ylabel": "median shift of layers [bins]",
    },
}
REACH = 4  # differences are shown up to so many times what is tolerated


def realism(realism, real_snow_radar):
    """Differences of all comparable quantities, and the curves that some of them make."""
    figure, axes = new_figure(2, 3, width=11, height=8, width_ratios=[1.3, 1, 1])
    # The constrained layout of axes that span rows differs in its last bits from run to run.
    figure.set_layout_engine("tight")
    for ax in axes[:, 0]:
        ax.remove()
    left = axes[0, 0].get_gridspec()[:, 0]
    plot_differences(figure.add_subplot(left), realism)
    for ax, (name, labels) in zip(axes[:, 1:].flat, CURVES.items(), strict=True):
        plot_curve(ax, realism, real_snow_radar, name)
        ax.set(**labels)
    return figure


def plot_differences(ax, table):
    """A point a comparable quantity: flight less real, in units of the tolerated difference."""
    rows = table.query("comparable").iloc[::-1]
    y = np.arange(len(rows))
    tolerated = rows["tolerated"]
    value = np.clip(rows["difference"] / tolerated, -REACH, REACH)
    low = np.abs(rows["low"] - rows["value"]) / tolerated
    high = np.abs(rows["high"] - rows["value"]) / tolerated
    colours = np.where(rows["agrees"] == "yes", BLACK, RED)
    ax.hlines(y, value - low, value + high, color=colours, linewidth=0.8)
    ax.scatter(value, y, s=8, c=colours)
    for limit in (-1, 1):
        ax.axvline(limit, **GUIDE)
    ax.set_yticks(y, rows["quantity"], fontsize=5)
    ax.set(xlim=(-REACH - 0.3, REACH + 0.3), ylim=(-1, len(rows)))
    ax.set_xlabel("flight - real, over what is tolerated")


def plot_curve(ax, table, real, name):
    """Quantities of one name by the number in it: the flight with bars, real frames as points."""
    observed = numbered(real, name)
    for frame, points in observed.groupby("frame", sort=False):
        style = {"color": BLUE, "linewidth": 0.7, "label": f"real, {frame}"}
        ax.plot("x", "value", "o--", data=points, **style)
    flight = numbered(table, name)
    value = flight["value"]
    reach = np.maximum([value - flight["low"], flight["high"] - value], 0)
    ax.errorbar(flight["x"], value, yerr=reach, fmt="o-", color=BLACK, label="flight")
    ax.axhline(0, **GUIDE)
    ax.legend()


def numbered(table, name):
    """Quantities of one name, with the number in their names as `x`."""
    number = table["quantity"].str.extract(rf"{name} at ([\d.]+) ", expand=False)
    return table.assign(x=number.astype(float)).dropna(subset="x")


def realism_crops(crops):
    """Crops of either side, a row a side and kind; only where real pictures are given."""
    names = sorted(crops.data_vars, key=lambda name: name.split(", ")[::-1])
    figure, axes = new_figure(len(names), crops.sizes["crop"], width=8, height=1.2 * len(names))
    for row, name in zip(axes, names, strict=True):
        for ax, crop in zip(row, crops[name].values, strict=True):
            ax.imshow(crop - crop.mean(), vmin=-5, vmax=5)
            ax.set(xticks=[], yticks=[])
        row[0].set_ylabel(name.replace(", ", "\n"), fontsize=7)
    return figure
