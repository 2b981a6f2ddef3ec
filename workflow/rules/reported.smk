# What the report shows: tables and figures that rules declare, and what studies have left.

import hashlib

from snakemake.io import get_flag_value


def declared_figures(wanted):
    """Figures that rules declare with a caption, those among `wanted`: file, caption's file, stage."""
    return [
        {
            "file": str(file),
            "caption": str((Path(item.snakefile).parent / flag.caption).resolve()),
            "stage": Path(item.snakefile).stem,
        }
        for item in workflow.rules
        for file in item.output
        if str(file) in wanted and (flag := get_flag_value(file, "report"))
    ]


def reported(folder):
    """What the default run makes under results/`folder`, in the order the stages name it."""
    return list(
        dict.fromkeys(
            str(file)
            for file in rules.all.input
            if str(file).startswith(f"results/{folder}/")
        )
    )


def study_files():
    """Tables and figures of studies that are there, by name with a digest of the content.

    What a study makes takes hours. It joins the page when it is there, and is no input of it: as one, a stale study
    would be rerun by the default run. The digests are parameters: they have the page written anew when one changes.
    """
    figures = figure_files("study_cgan") + figure_files("study_tracker")
    paths = [*Path("results/studies").glob("*/*.csv"), *map(Path, figures)]
    return {
        str(path): hashlib.sha256(path.read_bytes()).hexdigest()[:16]
        for path in sorted(paths)
        if path.is_file()
    }


def study_parts():
    """Names of the studies there are rules for."""
    return sorted(item.name.removeprefix("study_") for item in targets(prefix="study_"))


def measured_stages():
    """Stage of every rule whose jobs are measured, by the folder of its measurements."""
    return {
        Path(str(item.benchmark)).parts[2]: Path(item.snakefile).stem
        for item in workflow.rules
        if item.benchmark and str(item.benchmark).startswith("results/benchmarks/")
    }
