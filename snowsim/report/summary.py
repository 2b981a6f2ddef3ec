"""The few numbers a reader sees first."""

from snowsim.report.comparison import TRAINING_SETS
from snowsim.report.format import duration, signed3
from snowsim.report.verdicts import CONFIRMED, CONTRADICTED, MISSING, OPEN


def count_verdicts(claims):
    """How many claims got each verdict, without verdicts that none got."""
    counts = {name: sum(claim.verdict == name for claim in claims) for name in (CONFIRMED, CONTRADICTED, OPEN, MISSING)}
    return {name: count for name, count in counts.items() if count}


def summary_tiles(tables, claims, costs):
    """Names, values and notes of the summary: similarity, tracker, what augmentation gains, claims, time."""
    table2 = tables["table2"].set_index(["metric", "statistic"])
    fuse = tables["table3_intervals"]
    fuse = fuse[(fuse["output"] == "fuse") & (fuse["metric"] == "ods")].set_index("training_set")
    added = fuse.drop(index="rd")
    best = added["mean"].idxmax()
    row = added.loc[best]
    interval = f"[{signed3(row['difference_low'])}, {signed3(row['difference_high'])}]"
    ssim, psnr = table2.loc[("ssim", "mean")], table2.loc[("psnr", "mean")]
    counts = count_verdicts(claims)
    return [
        {
            "name": "SSIM with observed scenes",
            "value": f"cGAN {ssim['cgan']:.2f}, PHY {ssim['phy']:.2f}",
            "note": f"PSNR cGAN {psnr['cgan']:.1f} dB, PHY {psnr['phy']:.1f} dB; means over test scenes",
        },
        {
            "name": "Tracker on RD alone, fused ODS",
            "value": f"{fuse.loc['rd', 'mean']:.3f}",
            "note": f"95 % interval {fuse.loc['rd', 'low']:.3f} to {fuse.loc['rd', 'high']:.3f}",
        },
        {
            "name": "Best augmented set, fused ODS",
            "value": f"{TRAINING_SETS[best]} {signed3(row['difference'])}",
            "note": f"over RD, 95 % interval {interval}",
        },
        {
            "name": "The paper's claims",
            "value": f"{counts.get(CONFIRMED, 0)} of {len(claims)} confirmed",
            "note": ", ".join(f"{count} {name}" for name, count in counts.items() if name != CONFIRMED),
        },
        {
            "name": "Time of all jobs",
            "value": duration(sum(stage["wall_s"] for stage in costs)),
            "note": f"{sum(stage['n_jobs'] for stage in costs)} jobs, CPU {duration(sum(s['cpu_s'] for s in costs))}",
        },
    ]
