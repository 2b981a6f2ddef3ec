"""Tables of the accuracy page that studies fill."""

import pandas as pd
from table_parts import METRICS, SETS, difference, markdown, read, share, study


def cgan_seeds(results):
    """Table II of every training of the cGAN."""
    rows = [
        [r.run, *(f"{getattr(r, m):.{n}f}" for m, (_, n) in METRICS.items())]
        for r in study(results, "cgan/seeds").itertuples()
    ]
    return markdown(["training", *(name for name, _ in METRICS.values())], rows)


def cgan_widths(results):
    """Widths of the cGAN at equal steps and at equal time, beside PHY."""
    table = study(results, "cgan/widths")
    rows = [
        [
            "PHY" if r.method == "phy" else f"cGAN, width {r.width}, {r.mode.replace('_', ' ')}",
            r.n_steps or "",
            "" if pd.isna(r.seconds_per_step) else f"{1e3 * r.seconds_per_step:.0f}",
            f"{1e3 * r.seconds_per_render:.1f}",
            *(f"{getattr(r, m):.{n}f}" for m, (_, n) in METRICS.items()),
            "found" if r.n_faults else "",
        ]
        for r in table.itertuples()
    ]
    header = ["renderer", "steps", "ms a step", "ms a render", *(name for name, _ in METRICS.values()), "faults"]
    return markdown(header, rows)


def cgan_stability(results):
    """What the detectors say of short trainings, by learning rate and L1 weight."""
    rows = []
    for (rate, weight), runs in study(results, "cgan/stability").groupby(["learning_rate", "l1_weight"]):
        faulty = runs.loc[runs["verdict"] != "healthy", "verdict"]
        kinds = sorted({fault.split(":")[0] for verdict in faulty for fault in verdict.split("; ")})
        healthy = f"{len(runs) - len(faulty)} of {len(runs)}"
        rows.append([f"{rate:g}", f"{weight:g}", healthy, f"{runs['ssim'].mean():.2f}", f"{runs['psnr'].mean():.1f}"])
        rows[-1].append(", ".join(kinds))
    return markdown(["learning rate", "L1 weight", "healthy", "SSIM", "PSNR [dB]", "faults of the others"], rows)


def seeds(results):
    """Differences of the fuse between training sets, with many trainings."""
    table = study(results, "tracker/seeds")
    n = f"{table['n_replicas'].iloc[0]} trainings a set, {table['n_images'].iloc[0]} test scenes"
    rows = [
        [
            f"{SETS[r.training_set]} less {SETS[r.base]}",
            r.metric.upper(),
            f"{share(r.mean)} - {share(r.base_mean)}",
            difference(r),
            r.verdict,
            f"{r.detectable:.4f}",
        ]
        for r in table.itertuples()
    ]
    header = ["sets", "score", "means", "difference", "verdict", "smallest that this could tell"]
    return f"{n} (`studies/tracker/seeds.csv`):\n\n" + markdown(header, rows)


def ablation(results):
    """Fused ODS of every setting of the ablation on the validation scenes."""
    table = study(results, "tracker/ablation").query("metric == 'ods'")
    n = f"{table['n_replicas'].iloc[0]} trainings each, {table['n_images'].iloc[0]} validation scenes"
    return f"{n} (`studies/tracker/ablation.csv`):\n\n" + compared(table)


def chosen(results):
    """Fused ODS of the best settings on the test scenes."""
    table = study(results, "tracker/chosen").query("metric == 'ods'")
    n = f"{table['n_replicas'].iloc[0]} trainings each, {table['n_images'].iloc[0]} test scenes"
    return f"{n} (`studies/tracker/chosen.csv`):\n\n" + compared(table)


def compared(table):
    """Settings, each less the setting and set it is compared with."""
    rows = [
        [
            r.setting.replace("_", " "),
            SETS[r.training_set],
            share(r.mean),
            "" if same else f"{r.base.replace('_', ' ')}, {SETS[r.base_training_set]}",
            "" if same else difference(r),
            "" if same else r.verdict,
        ]
        for r in table.itertuples()
        for same in [(r.setting, r.training_set) == (r.base, r.base_training_set)]
    ]
    return markdown(["setting", "set", "ODS", "compared with", "difference", "verdict"], rows)


def networks(results):
    """Trackers of other cost."""
    fastest = read(results, "speed_accuracy_tracker").sort_values("seconds").groupby("setting", sort=False).first()
    rows = [
        [
            f"{r.network.replace('_', '-')}, width {r.width}",
            f"{r.n_parameters:,}",
            f"{1e3 * r.seconds:.0f}",
            share(r.ods),
        ]
        for r in fastest.sort_values(["network", "width"]).itertuples()
    ]
    return markdown(["network", "weights", "ms an image", "ODS"], rows)


def tracker_stability(results):
    """What becomes of a tracker under odd input and rates."""
    rows = []
    for panel, of_panel in study(results, "tracker/stability").groupby("panel", sort=False):
        cells = [f"{value:g}: {result_of(runs)}" for value, runs in of_panel.groupby("value", sort=False)]
        rows.append([panel, ", ".join(cells)])
    return markdown(["panel", "value: result"], rows)


def result_of(runs):
    """Mean result of runs, or what became of them."""
    failed = runs.loc[runs["status"] != "ok", "status"]
    return f"{runs['result'].mean():.2f}" if failed.empty else failed.iloc[0]


STUDY_BLOCKS = (cgan_seeds, cgan_widths, cgan_stability, seeds, ablation, chosen, networks, tracker_stability)
