"""Tables of the page on tracking that the study of flights never seen fills."""

import numpy as np
from table_parts import markdown, read, share

TRACKERS = {
    "universal": "universal",
    "rd": "RD",
    "pd": "PD",
    "rd_pd": "RD+PD",
    "control": "the flight's own 60",
}
SHOWN_CLASSES = 0.01  # least share of picks in a class of confidence that is shown


def transfer(results):
    """Edge scores of all trackers on every flight, and their means."""
    table = read(results, "transfer").set_index(["flight", "tracker"])
    rows = []
    for flight in table.index.unique("flight"):
        of_flight = table.loc[flight]
        row = [flight.replace("_", " ")]
        for name in TRACKERS:
            scores = of_flight.loc[name]
            row.append("/".join(share(scores[metric]) for metric in ("ods", "ois", "ap")))
        rows.append(row)
    return "ODS / OIS / AP (`transfer.csv`):\n\n" + markdown(["flight", *TRACKERS.values()], rows)


def transfer_picks(results):
    """Picks of the universal tracker and of the control on every flight."""
    table = read(results, "transfer").set_index(["flight", "tracker"])
    rows = []
    for flight in table.index.unique("flight"):
        for name in ("universal", "control"):
            scores = table.loc[(flight, name)]
            row = [flight.replace("_", " "), TRACKERS[name]]
            row += [share(scores[each]) for each in ("f", "recall", "precision")]
            row.append(f"{scores['mean_error_bins']:.2f}")
            row += [f"{100 * scores[each]:.0f} %" for each in ("missed_share", "false_share")]
            rows.append(row)
    header = ["flight", "tracker", "F", "recall", "precision", "error [bins]", "missed", "false"]
    return markdown(header, rows)


def transfer_confidence(results):
    """How often picks of the universal tracker hit, by what it said: means over flights."""
    table = read(results, "transfer_reliability").query("tracker == 'universal'").copy()
    table["place"] = table.groupby("flight").cumcount()
    n_picks = table["n_pixels"]
    table["n_picks"] = n_picks / n_picks.groupby(table["flight"]).transform("sum")
    mean = table.groupby("place")[["said", "seen", "n_picks"]].mean()
    shown = mean[mean["n_picks"] >= SHOWN_CLASSES]
    rows = [[share(r.said), share(r.seen), f"{100 * r.n_picks:.0f} %"] for r in shown.itertuples()]
    largest = np.abs(shown["said"] - shown["seen"]).max()
    title = f"Largest difference {largest:.3f} (`transfer_reliability.csv`):\n\n"
    return title + markdown(["said", "within 2 bins of a layer", "picks"], rows)


TRANSFER_BLOCKS = (transfer, transfer_picks, transfer_confidence)
