# Checked before the first job of a run: is there room for what it will write, may it write there.

# What scenes and frames take on disk, from a run of the default configuration: see docs/scale.md. The rest is small.
BYTES_PER_SCENE = {
    "draw_labels": 18e3,
    "render_phy": 220e3,
    "render_cgan": 220e3,
    "reference_scenes": 110e3,
}
BYTES_PER_FRAME_LINE = 3.7e3
SMALL_FILES_BYTES = 20e6


def bytes_of(job):
    """About what one job writes."""
    scenes = job.wildcards.get("scenes", job.wildcards.get("split", "labels"))
    if job.rule.name in BYTES_PER_SCENE:
        first, end = shard_range(scenes, job.wildcards.shard)
        return (end - first) * BYTES_PER_SCENE[job.rule.name]
    if job.rule.name.startswith("reference_frames_"):
        n_lines = len(job.output.echograms) * config["flight"]["n_range_lines"]
        return n_lines * BYTES_PER_FRAME_LINE
    return 0


def check_folders(*names):
    """Refuse to start where results or logs cannot be written; root may write anywhere but on a read-only disk."""
    for name in names:
        folder = Path(name).absolute()
        while not folder.exists():
            folder = folder.parent
        if not os.access(folder, os.W_OK):
            raise WorkflowError(
                f"disk: {name}/ cannot be written: {folder} is read-only"
            )


def check_disk(jobs):
    """Refuse to start what the disk has no room for."""
    needed = SMALL_FILES_BYTES + sum(map(bytes_of, jobs))
    folder = Path("results").absolute()
    folder = folder if folder.exists() else folder.parent
    free = shutil.disk_usage(folder).free
    if free < needed:
        raise WorkflowError(
            f"disk: this run writes about {needed / 1e6:.0f} MB, {folder} has {free / 1e6:.0f} MB left"
        )


onstart:
    check_folders("results", "logs")
    check_disk(workflow.dag.needrun_jobs())
