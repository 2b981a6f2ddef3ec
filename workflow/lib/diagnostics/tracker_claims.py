"""Claims on trackers: what synthetic scenes in the training set do for edge scores."""

from lib.diagnostics.verdicts import CONFIRMED, CONTRADICTED, OPEN, Verdict, all_of, side_of_zero, signed

BY_BOOTSTRAP = "The interval is the paired bootstrap over trainings and images."
SETS = {"rd_gd": "RD+GD", "rd_pd": "RD+PD", "rd_pd_gd": "RD+PD+GD"}
SIDES = [f"side_{side}" for side in range(1, 6)]


def _row(intervals, output, training_set, metric):
    chosen = intervals[
        (intervals["output"] == output) & (intervals["training_set"] == training_set) & (intervals["metric"] == metric)
    ]
    return chosen.iloc[0]


def _difference(row):
    return f"{signed(row['difference'])} [{signed(row['difference_low'])}, {signed(row['difference_high'])}]"


def augmentation(intervals, metric):
    """Augmentation raises one score of the fused output."""
    rows = {name: _row(intervals, "fuse", name, metric) for name in SETS}
    verdicts = [side_of_zero(row["difference_low"], row["difference_high"]) for row in rows.values()]
    parts = "; ".join(
        f"{SETS[name]} {_difference(row)} ({v})" for (name, row), v in zip(rows.items(), verdicts, strict=True)
    )
    first = next(iter(rows.values()))
    return Verdict(
        f"Augmentation raises the fused output's {metric.upper()}.",
        all_of(verdicts),
        f"Difference to RD with 95 % interval: {parts}.",
        "Confirmed where all three training sets gain, contradicted where one of them loses, else not resolved. "
        + BY_BOOTSTRAP,
        f"{int(first['n_replicas'])} trainings of each set.",
    )


def best_fuse(intervals):
    """RD+PD has the best fused ODS."""
    rows = {name: _row(intervals, "fuse", name, "ods") for name in SETS}
    ours, others = rows["rd_pd"], {name: row for name, row in rows.items() if name != "rd_pd"}
    if ours["difference_high"] < 0 or any(row["difference_low"] > ours["difference_high"] for row in others.values()):
        verdict = CONTRADICTED
    elif ours["difference_low"] > max(0, *(row["difference_high"] for row in others.values())):
        verdict = CONFIRMED
    else:
        verdict = OPEN
    means = ", ".join(f"{SETS[name]} {row['mean']:.3f}" for name, row in rows.items())
    return Verdict(
        "RD+PD gives the best fused ODS.",
        verdict,
        f"RD {_row(intervals, 'fuse', 'rd', 'ods')['mean']:.3f}, {means}. RD+PD less RD {_difference(ours)}.",
        "Confirmed where the interval of RD+PD less RD lies above zero and above those of the other sets; contradicted "
        "where it lies below zero or below one of them; else not resolved. " + BY_BOOTSTRAP,
    )


def best_sides(intervals):
    """RD+GD has the best side outputs."""
    best, gains, losses, parts = 0, 0, 0, []
    for side in SIDES:
        means = {name: _row(intervals, side, name, "ods")["mean"] for name in ("rd", *SETS)}
        row = _row(intervals, side, "rd_gd", "ods")
        leads = max(means, key=means.get) == "rd_gd"
        best += leads
        gains += leads and row["difference_low"] > 0
        losses += row["difference_high"] < 0 or not leads
        parts.append(f"side {side[-1]} {_difference(row)}{', the best' if leads else ''}")
    verdict = CONFIRMED if gains >= 3 else CONTRADICTED if losses >= 3 else OPEN
    return Verdict(
        "RD+GD gives the best side outputs.",
        verdict,
        f"ODS of RD+GD less RD: {'; '.join(parts)}. The best of the four sets on {best} of 5 side outputs.",
        "Confirmed where RD+GD leads on at least 3 of the 5 side outputs with an interval above zero, contradicted "
        "where on 3 or more another set leads, else not resolved. " + BY_BOOTSTRAP,
    )


def fifth_side(intervals):
    """Side output 5 gets worse with synthetic data."""
    rows = {name: _row(intervals, "side_5", name, "ods") for name in SETS}
    verdicts = [side_of_zero(-row["difference_high"], -row["difference_low"]) for row in rows.values()]
    return Verdict(
        "Side output 5 gets worse with synthetic data.",
        all_of(verdicts),
        "ODS less RD's: " + "; ".join(f"{SETS[name]} {_difference(row)}" for name, row in rows.items()) + ".",
        "Confirmed where all three sets lose, contradicted where one of them gains, else not resolved. " + BY_BOOTSTRAP,
    )
