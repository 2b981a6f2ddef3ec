"""The list of targets that ``snakemake help`` prints."""

GROUPS = {
    "main": "from the flight to Tables II and III",
    "pretrained": "the tracker that comes with the package, and what it picks; not part of the "
    "default run",
    "evaluation": "what judges and shows; nothing on the main path depends on it",
    "studies": "many trainings each, not part of the default run",
}


def group_of(target):
    """Group of a target, by the file of its rule."""
    if target.name.startswith("stud"):
        return "studies"
    if target.snakefile.endswith(("/pretrained.smk", "/picks.smk")):
        return "pretrained"
    return "evaluation" if "/evaluation/" in target.snakefile else "main"


def described(targets):
    """Targets in groups, a line of text for each."""
    width = max(len(target.name) for target in targets)
    lines = ["snakemake --cores N TARGET; targets are:"]
    for group, about in GROUPS.items():
        members = [target for target in targets if group_of(target) == group]
        if members:
            lines.append(f"{group}: {about}")
        lines += [f"  {target.name:<{width}}  {target.message}" for target in members]
    return "\n".join(lines)
