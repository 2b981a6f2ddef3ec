"""Tables of the accuracy page that studies fill."""

from table_parts import METRICS, RUNS, SETS, difference, markdown, read, share

NAMES = [name for name, _ in METRICS.values()]


def renderers(results):
    """Cost and worth of every renderer of label sets, means of trainings; positions of layers of uniform label sets."""
    positions = (
        read(results, "positions", "studies/cgan").groupby("renderer")["error_bins"].median()
    )
    rows = []
    for name, runs in read(results, "renderers", "studies/cgan").groupby("renderer", sort=False):
        mean = runs.mean(numeric_only=True)
        shares = [
            share(mean[key]) for key in ("two_sample_network", "two_sample_texture", "ods", "ap")
        ]
        rows.append(
            [name, f"{1e9 * mean['seconds_per_pixel']:.0f}", *shares, f"{positions[name]:.2f}"]
        )
    header = ["renderer", "ns a pixel", "network", "texture", "ODS", "AP", "position error [bins]"]
    return markdown(header, rows)


def budgets(results):
    """Scores of every network by what its training costs, means of trainings."""
    rows = []
    for network in ("tracker", "cgan"):
        table = read(results, network, "studies/budgets").fillna(
            {"change": "default", "trained_on": ""}
        )
        shown = {"rd": "ods", "pd": "ods", "": "distance"}
        of_changes = table.groupby("change", sort=False)
        for change, runs in of_changes:
            by_set = [
                (name, shown[name], part) for name, part in runs.groupby("trained_on", sort=False)
            ]
            scores = ", ".join(
                f"{RUNS.get(name, score)} {share(part[score].mean()) if name else f'{part[score].mean():.2f}'}"
                for name, score, part in by_set
            )
            rows.append([network, change, f"{runs['core_seconds'].mean():.0f}", scores])
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
    return markdown(
        ["learning rate", "L1 weight", "healthy", "SSIM", "PSNR [dB]", "faults of the others"], rows
    )


def worth(results):
    """Fused scores of training sets less those of others."""
    table = read(results, "worth", "studies/tracker")
    rows = []
    for r in table.itertuples():
        runs = (r.training_set, r.setting), (r.base_training_set, r.base)
        names = [
            RUNS[s] + ("" if how == "default" else f", {how.replace('_', ' ')}") for s, how in runs
        ]
        resampled = f"[{r.bootstrap_low:+.4f}, {r.bootstrap_high:+.4f}]"
        means = f"{share(r.mean)} - {share(r.base_mean)}"
        rows.append(
            [" less ".join(names), r.metric.upper(), means, difference(r), resampled, r.outcome]
        )
    header = ["sets", "score", "means", "difference", "bootstrap", "outcome"]
    return counted(table, "worth", "a set", "test") + markdown(header, rows)


def ablation(results):
    """Fused ODS of every setting, each less the setting and set it is compared with, on the validation scenes."""
    table = read(results, "ablation", "studies/tracker").query("metric == 'ods'")
    rows = []
    for r in table.itertuples():
        rows.append([r.setting.replace("_", " "), SETS[r.training_set], share(r.mean)])
        if (r.setting, r.training_set) == (r.base, r.base_training_set):
            rows[-1] += ["", "", ""]
        else:
            rows[-1] += [
                f"{r.base.replace('_', ' ')}, {SETS[r.base_training_set]}",
                difference(r),
                r.outcome,
            ]
    header = ["setting", "set", "ODS", "compared with", "difference", "outcome"]
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


STUDY_BLOCKS = (budgets, renderers, cgan_atlas, worth, ablation, tracker_atlas)
