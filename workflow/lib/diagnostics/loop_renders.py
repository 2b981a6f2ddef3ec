"""Label sets rendered by one convention of PHY, and what their statistics give back of those that went in."""

import pandas as pd

from lib.diagnostics.closed_loop import as_frame, compare, largest_errors, thinned
from snowsim.phy import draw_parameters, plan, render_plan
from snowsim.statistics import estimate, merge, summarise


def summarise_renders(scenes, given, convention, tolerance_db, stride, stream):
    """Sums over renders of (number, scene) by statistics `given`; `stream` gives the random generator of a scene.

    A convention is named ``<estimator>_<normalise>_<align>_<width>``.
    """
    geometry = {name: given.attrs[name] for name in ("bin_size_s", "line_spacing_m")}
    _, normalise, align, width = convention.split("_")
    options = {"tolerance_db": tolerance_db, "speckle": "gamma", "normalise": normalise, "align": align}
    summaries = []
    for number, scene in scenes:
        # By scene, never by part; where no width is drawn, the same speckle for every convention.
        rng = stream(scene.name)
        # As many looks as the flight, so that 20 lines average as many here as there.
        parameters = draw_parameters(given, scene.layer_bins.shape[0], width=width, rng=rng)
        power = render_plan(plan(scene.layer_bins, parameters, scene.n_range_bins, **options), rng=rng)
        frame = as_frame(power, scene.layer_bins, number, **geometry)
        summaries.append(thinned(summarise(*frame, where=scene.name), stride))
    return merge(summaries)


def recover(summary, given):
    """Statistics of renders, zone by zone as the flight's, and their table beside those that were to be `given`."""
    recovered = estimate(summary, estimator=given.attrs["estimator"], zone_edge_bins=given["zone_edge_bins"].values)
    return recovered.assign_attrs(synthetic="renders by PHY, not observed data"), compare(given, recovered)


def convention_table(tried):
    """A row a convention, of (its name, table of `recover`, number of scenes); the least `score` comes closest."""
    rows = []
    for convention, errors, n_scenes in tried:
        names = dict(zip(("estimator", "normalise", "align", "width"), convention.split("_"), strict=True))
        rows.append(names | {"n_scenes": n_scenes} | largest_errors(errors))
    table = pd.DataFrame(rows)
    table.insert(5, "closest", table["score"] == table["score"].min())
    return table
