"""Numbers, names and settings as the page writes them."""

import pandas as pd

# Headings of stages; others are called by their own names.
STAGES = {
    "flight": "The flight and its statistics",
    "labels": "Label sets",
    "renders": "Renders by PHY and by the conditional GAN",
    "similarity": "Similarity of renders to observed scenes",
    "tracker": "Layer trackers",
    "phy": "Speed against accuracy of PHY",
    "atlas": "Atlases: where methods fail",
    "convolution": "How good is the convolution model?",
}


def stage_name(stage):
    """A stage as a heading."""
    name = STAGES.get(stage, stage.removeprefix("study_").replace("_", " "))
    return name[:1].upper() + name[1:]


def groupby_stage(figures):
    """Figures of each stage, (stage, figures), in the order they come."""
    stages = {}
    for figure in figures:
        stages.setdefault(figure["stage"], []).append(figure)
    return list(stages.items())


def duration(seconds):
    """Seconds as "45 s", "3 min 20 s" or "2 h 5 min"."""
    if seconds < 10:
        return f"{seconds:.1f} s"
    if seconds < 60:
        return f"{seconds:.0f} s"
    minutes, seconds = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes} min" if hours else f"{minutes} min {seconds} s"


def size(n_bytes):
    """Bytes as "820 B", "12 kB" or "1.3 MB"."""
    for unit, scale in (("MB", 1e6), ("kB", 1e3)):
        if n_bytes >= scale:
            value = n_bytes / scale
            return f"{value:.1f} {unit}" if value < 10 else f"{value:.0f} {unit}"
    return f"{n_bytes} B"


def cell(value):
    """A table's value: floats with four digits, nothing where there is none."""
    if pd.isna(value):
        return ""
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def signed3(value):
    """A difference with three decimals and a real minus sign."""
    return f"{value:+.3f}".replace("-", "\N{MINUS SIGN}")


def config_lines(config, prefix=""):
    """Settings as "section.key" and value, in the order of the configuration."""
    lines = []
    for key, value in config.items():
        name = prefix + key
        if isinstance(value, dict) and value:
            lines += config_lines(value, f"{name}.")
        else:
            lines.append((name, str(value)))
    return lines


FILTERS = {
    "groupby_stage": groupby_stage,
    "stage_name": stage_name,
    "duration": duration,
    "size": size,
    "cell": cell,
    "signed3": signed3,
}
