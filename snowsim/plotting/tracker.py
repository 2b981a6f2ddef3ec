"""Edge scores and training of the trackers."""

from snowsim.plotting.style import COLOURS, NAMES


def plot_precision_recall(ax, curves):
    """Precision against recall of the fused output, a line a training set, mean over replicas."""
    for training_set, rows in curves.groupby("training_set", sort=False):
        ax.plot(rows["recall"], rows["precision"], color=COLOURS[training_set], label=NAMES[training_set])
    ax.set(xlabel="recall", ylabel="precision", xlim=(0, 1), ylim=(0, 1))
    ax.legend(loc="lower left")


def plot_scores(ax, intervals, metric):
    """One edge score of the fused output, a point with its 95 % interval a training set."""
    rows = intervals[(intervals["output"] == "fuse") & (intervals["metric"] == metric)]
    for x, row in enumerate(rows.itertuples()):
        ax.plot([x, x], [row.low, row.high], color=COLOURS[row.training_set])
        ax.plot(x, row.mean, "o", color=COLOURS[row.training_set])
    ax.set_xticks(range(len(rows)), [NAMES[name] for name in rows["training_set"]], rotation=30, ha="right")
    ax.set_ylabel(f"{NAMES[metric]} of fuse")


def plot_losses(ax, losses, columns, window=50):
    """Training losses against step as running means over `window` steps."""
    for column in columns:
        smooth = losses[column].rolling(window, min_periods=1).mean()
        ax.plot(losses["step"], smooth, linewidth=1, label=column)
    ax.set(xlabel="step", ylabel="loss")
