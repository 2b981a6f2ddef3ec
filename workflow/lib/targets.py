"""What people can ask the workflow for by name, in words."""

GROUPS = {
    "main": "from the flight to Tables II and III",
    "pretrained": "the tracker that comes with the package, and what it picks; not part of the "
    "default run",
    "evaluation": "what judges and shows; nothing on the main path depends on it",
    "studies": "many trainings each, not part of the default run",
}


def group_of(target):
    """The group of a target, by where its rule stands."""
    if target.name.startswith("stud"):
        return "studies"
    if target.snakefile.endswith(("/pretrained.smk", "/picks.smk")):
        return "pretrained"
    return "evaluation" if "/evaluation/" in target.snakefile else "main"


def described(targets):
    """Rules that are targets with a line each, in groups."""
    width = max(len(target.name) for target in targets)
    lines = ["snakemake --cores N TARGET; targets are:"]
    for group, about in GROUPS.items():
        members = [target for target in targets if group_of(target) == group]
        if members:
            lines.append(f"{group}: {about}")
        lines += [f"  {target.name:<{width}}  {target.message}" for target in members]
    return "\n".join(lines)
