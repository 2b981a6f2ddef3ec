"""How near the flight comes to real Snow Radar: all quantities, curves of autocorrelation, and crops side by side."""

import numpy as np

from lib.figures.style import BLACK, BLUE, RED, new_figure

CURVES = {
    "Greenland, autocorrelation along track": ("distance [m]", "autocorrelation, 100 m means"),
    "snow, autocorrelation along track": (
        "distance [range lines]",
        "autocorrelation, homogeneous snow",
    ),
    "air, autocorrelation down": ("delay [ns]", "autocorrelation, air"),
    "Greenland, shift of layers": ("distance [m]", "median shift of layers [bins]"),
}
REACH = 4  # differences are shown up to so many times what is tolerated


def realism(realism, real_snow_radar):
    """Differences of all comparable quantities, and the curves that some of them make."""
    figure, axes = new_figure(2, 3, width=11, height=8, width_ratios=[1.3, 1, 1])
    # The constrained layout of axes that span rows differs in its last bits from run to run.
    figure.set_layout_engine("tight")
    for ax in axes[:, 0]:
        ax.remove()
    plot_differences(figure.add_subplot(axes[0, 0].get_gridspec()[:, 0]), realism)
    for ax, (name, (xlabel, ylabel)) in zip(axes[:, 1:].flat, CURVES.items(), strict=True):
        plot_curve(ax, realism, real_snow_radar, name)
        ax.set(xlabel=xlabel, ylabel=ylabel)
    return figure


def plot_differences(ax, table):
    """A point a comparable quantity: flight less real, in units of the tolerated difference."""
    rows = table[table["comparable"]].iloc[::-1]
    y = np.arange(len(rows))
    value = np.clip(rows["difference"] / rows["tolerated"], -REACH, REACH)
    reach = np.abs(rows[["low", "high"]].sub(rows["value"], axis=0)).div(rows["tolerated"], axis=0)
    colours = np.where(rows["agrees"] == "yes", BLACK, RED)
    ax.hlines(y, value - reach["low"], value + reach["high"], color=colours, linewidth=0.8)
    ax.scatter(value, y, s=8, c=colours)
    for limit in (-1, 1):
        ax.axvline(limit, color="0.5", linestyle=":", linewidth=1)
    ax.set_yticks(y, rows["quantity"], fontsize=5)
    ax.set(
        xlim=(-REACH - 0.3, REACH + 0.3),
        ylim=(-1, len(rows)),
        xlabel="flight - real, over what is tolerated",
    )


def plot_curve(ax, table, real, name):
    """Quantities of one name by the number in it: the flight as a line with bars, real frames as points."""
    pattern = rf"{name} at ([\d.]+) "
    flight, observed = (
        rows.assign(x=rows["quantity"].str.extract(pattern)[0].astype(float)).dropna(subset="x")
        for rows in (table, real)
    )
    for frame, points in observed.groupby("frame", sort=False):
        ax.plot(
            points["x"],
            points["value"],
            "o--",
            color=BLUE,
            markersize=3,
            linewidth=0.7,
            label=f"real, {frame}",
        )
    reach = [flight["value"] - flight["low"], flight["high"] - flight["value"]]
    style = {"fmt": "o-", "color": BLACK, "markersize": 3, "label": "flight"}
    ax.errorbar(flight["x"], flight["value"], yerr=np.maximum(reach, 0), **style)
    ax.axhline(0, color="0.5", linestyle=":", linewidth=1)
    ax.legend(fontsize=6)


def realism_crops(crops):
    """Crops of either side, a row a side and kind; only where real pictures are given."""
    names = sorted(crops.data_vars, key=lambda name: name.split(", ")[::-1])
    figure, axes = new_figure(len(names), crops.sizes["crop"], width=8, height=1.2 * len(names))
    for row, name in zip(axes, names, strict=True):
        for ax, crop in zip(row, crops[name].values, strict=True):
            ax.imshow(
                crop - crop.mean(),
                cmap="gray",
                vmin=-5,
                vmax=5,
                aspect="auto",
                interpolation="none",
            )
            ax.set(xticks=[], yticks=[])
        row[0].set_ylabel(name.replace(", ", "\n"), fontsize=7)
    return figure
