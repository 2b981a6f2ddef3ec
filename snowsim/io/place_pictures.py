"""Pictures of the layers of two passes side by side, at the places where their tracks meet."""

import numpy as np

from snowsim.io.files import written_whole
from snowsim.io.pictures import NO_MATPLOTLIB

MOST_PANELS = 24  # of more places, so many are drawn, spread evenly over their order
N_COLUMNS = 6
PANEL_INCHES = (2.3, 3.6)
# Columns of a panel: ends of a layer's tick in the first segment, and in the second.
FIRST, SECOND = (0.0, 1.0), (2.0, 3.0)
MATCHED, ALONE, NOT_COUNTED = "#0072b2", "#d55e00", "#bbbbbb"


def write_places(path, found):
    """Write a PNG of a result of `snowsim.agreement`: both profiles at each place, at most at 24.

    Layers of the first segment are at the left of a panel, those of the second at the right, with
    their years; a line joins the two of a match. Layers without a partner are orange, layers that
    are not counted grey. Needs matplotlib.
    """
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise ValueError(NO_MATPLOTLIB) from error
    n_places = found.sizes["place"]
    shown = np.unique(np.linspace(0, n_places - 1, min(n_places, MOST_PANELS)).round().astype(int))
    n_columns = min(N_COLUMNS, shown.size)
    n_rows = -(-shown.size // n_columns)
    width, height = PANEL_INCHES
    size = (max(n_columns, 2) * width, 0.6 + n_rows * height)
    figure = Figure(figsize=size, layout="constrained")
    panels = figure.subplots(n_rows, n_columns, squeeze=False)
    for panel in panels.ravel()[shown.size :]:
        panel.set_axis_off()
    layers = found[[name for name, of in found.items() if of.dims == ("layer",)]].to_dataframe()
    for number, panel in zip(shown, panels.ravel(), strict=False):
        own = layers[layers["layer_place"] == number]
        _draw_place(panel, found.isel(place=number), own)
    for panel in panels[:, 0]:
        panel.set_ylabel("depth [m]", fontsize=7)
    some = f", {shown.size} of {n_places} places" if shown.size < n_places else ""
    figure.suptitle(
        f"blue: matched layers; orange: without a partner; grey: not counted{some}", fontsize=8
    )
    with written_whole(path) as aside:
        figure.savefig(aside, format="png", dpi=110)


def _draw_place(axes, place, layers):
    """Draw the layers of one place, a row each, as ticks with their years."""
    for layer in layers.itertuples():
        depths_m = (layer.depth_first_m, layer.depth_second_m)
        is_match = np.isfinite(depths_m).all()
        colour = MATCHED if is_match else ALONE if layer.counted else NOT_COUNTED
        for ends, depth_m in zip((FIRST, SECOND), depths_m, strict=True):
            axes.plot(ends, [depth_m, depth_m], color=colour, lw=1.2)
        if is_match:
            axes.plot([FIRST[1], SECOND[0]], depths_m, color=colour, lw=0.5)
        years = (layer.year_first, layer.year_second)
        for at, depth_m, year, side in zip(
            (FIRST[0], SECOND[1]), depths_m, years, ("right", "left"), strict=True
        ):
            if np.isfinite(year) and np.isfinite(depth_m):
                beside = -0.1 if side == "right" else 0.1
                axes.text(at + beside, depth_m, f"{year:g}", fontsize=5, ha=side, va="center")
    # Snow that fell between the flights lies above the surface of the earlier one.
    axes.axhline(0, color="black", lw=0.5)
    depths_m = layers[["depth_first_m", "depth_second_m"]].to_numpy()
    deepest_m = np.nanmax(depths_m, initial=1)
    highest_m = np.nanmin(depths_m, initial=0)
    margin_m = 0.04 * (deepest_m - highest_m)
    axes.set(xlim=(-1.2, 4.2), xticks=[0.5, 2.5])
    axes.set_ylim(deepest_m + margin_m, highest_m - margin_m)
    axes.set_xticklabels([str(place[name].values) for name in ("first", "second")], fontsize=6)
    axes.tick_params(labelsize=6)
    offset, angle_deg, distance_m, days = (
        float(place[name]) for name in ("offset_years", "angle_deg", "distance_m", "days_between")
    )
    years = f"offset {offset:g} years" if np.isfinite(offset) else "not dated"
    axes.set_title(
        f"{place['kind'].values} {place['meeting'].values}, {angle_deg:.0f} degrees\n"
        f"{distance_m:.0f} m, {days:.1f} days, {years}",
        fontsize=6,
    )
