"""Tables of the accuracy page that studies fill."""

from flight_tables import FLIGHT_BLOCKS
from table_parts import RUNS, difference, markdown, read, share


def renderers(results):
    """Cost and worth of every renderer, means of trainings; positions of layers of label sets."""
    positions = read(results, "positions", "studies/cgan").groupby("renderer")["error_bins"]
    table = read(results, "renderers", "studies/cgan")
    means = table.groupby("renderer", sort=False).mean(numeric_only=True)
    means["position"] = positions.median()[means.index]
    rows = []
    for name, mean in means.iterrows():
        scores = mean[["two_sample_network", "two_sample_texture", "ods", "ap"]]
        cost = f"{1e9 * mean['seconds_per_pixel']:.0f}"
        rows.append([name, cost, *scores.map(share), f"{mean['position']:.2f}"])
    header = ["renderer", "ns a pixel", "network", "texture", "ODS", "AP", "position error [bins]"]
    return markdown(header, rows)


def budgets(results):
    """Scores of every network by what its training costs, means of trainings."""
    rows = []
    for network in ("tracker", "cgan"):
        table = read(results, network, "studies/budgets")
        table = table.fillna({"change": "default", "trained_on": ""})
        for change, runs in table.groupby("change", sort=False):
            scores = []
            for name, part in runs.groupby("trained_on", sort=False):
                if name:
                    scores.append(f"{RUNS[name]} {share(part['ods'].mean())}")
                else:
                    scores.append(f"distance {part['distance'].mean():.2f}")
            seconds = runs["core_seconds"].mean()
            rows.append([network, change, f"{seconds:.0f}", ", ".join(scores)])
    return markdown(["network", "differs from the default", "core-seconds", "score"], rows)


def cgan_atlas(results):
    """What the detectors find in short trainings, by learning rate and L1 weight."""
    rows = []
    table = read(results, "atlas", "studies/cgan")
    for (rate, weight), runs in table.groupby(["learning_rate", "l1_weight"]):
        faulty = runs.loc[runs["outcome"] != "healthy", "outcome"]
        kinds = sorted({fault.split(":")[0] for outcome in faulty for fault in outcome.split("; ")})
        healthy = f"{len(runs) - len(faulty)} of {len(runs)}"
        means = [f"{runs['ssim'].mean():.2f}", f"{runs['psnr'].mean():.1f}"]
        rows.append([f"{rate:g}", f"{weight:g}", healthy, *means, ", ".join(kinds)])
    header = ["learning rate", "L1 weight", "healthy", "SSIM", "PSNR [dB]", "faults of the others"]
    return markdown(header, rows)


def ablation(results):
    """Fused scores of every setting on the validation scenes, and what they lose to the default."""
    table = read(results, "ablation", "studies/tracker").query("metric != 'ois'")
    rows = []
    for r in table.itertuples():
        row = [r.setting.replace("_", " "), RUNS[r.training_set], r.metric.upper(), share(r.mean)]
        row += ["", ""] if r.setting == r.base else [difference(r), r.outcome]
        rows.append(row)
    header = ["setting", "set", "score", "mean", "less the default", "outcome"]
    return counted(table, "ablation", "each", "validation") + markdown(header, rows)


def counted(table, name, of_what, scenes):
    """How many trainings and scenes a table of the tracker's study rests on, and its file."""
    first = table.iloc[0]
    n = f"{first['n_replicas']} trainings {of_what}, {first['n_images']} {scenes} scenes"
    return f"{n} (`studies/tracker/{name}.csv`):\n\n"


def tracker_atlas(results):
    """What becomes of a tracker under odd input and rates."""
    rows = []
    for panel, of_panel in read(results, "atlas", "studies/tracker").groupby("panel", sort=False):
        cells = [
            f"{value:g}: {result_of(runs)}" for value, runs in of_panel.groupby("value", sort=False)
        ]
        rows.append([panel, ", ".join(cells)])
    return markdown(["panel", "value: result"], rows)


def result_of(runs):
    """Mean result of runs, or what became of them."""
    failed = runs.loc[runs["status"] != "ok", "status"]
    return f"{runs['result'].mean():.2f}" if failed.empty else failed.iloc[0]


# Tables that are made from label sets of the run that they lie in.
STUDY_FILES = {
    "budgets": "studies/budgets/tracker.csv",
    "renderers": "studies/cgan/renderers.csv",
    "cgan_atlas": "studies/cgan/atlas.csv",
    "worth": "studies/tracker/worth.csv",
    "ablation": "studies/tracker/ablation.csv",
    "tracker_atlas": "studies/tracker/atlas.csv",
}
STUDY_BLOCKS = (budgets, renderers, cgan_atlas, ablation, tracker_atlas, *FLIGHT_BLOCKS)
