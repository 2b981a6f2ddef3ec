# Scenes for other people's code, as image pairs in the published benchmark's layout.

EXPORT = config["export"]
# Files of every exported set by split, and below what the set is, in words.
EXPORTS = {
    "rd": {split: benchmark_files(split) for split in SPLITS if N_SCENES[split]},
    "pd": {"train": rendered_files("phy", "labels")},
    "gd": {"train": rendered_files("cgan", "labels")},
}
WHAT = {
    "rd": f"observed scenes ({NOTE})",
    "pd": f"label sets rendered by PHY, drawn from statistics of {NOTE}",
    "gd": f"label sets rendered by cGAN, drawn from statistics of {NOTE}",
}


rule export_scenes:
    input:
        scenes=lambda w: sum(EXPORTS[w.set].values(), []),
    output:
        folder=directory("results/export/pairs/{set}"),
    log:
        "logs/export_scenes/{set}.log",
    benchmark:
        "results/benchmarks/export_scenes/{set}.tsv"
    params:
        lists=lambda w: EXPORTS[w.set],
        layers=EXPORT["layers"],
        what=lambda w: WHAT[w.set],
    message:
        "{wildcards.set} as image pairs"
    script:
        "../scripts/export_scenes.py"


rule export:
    input:
        expand("results/export/pairs/{set}", set=EXPORT["sets"]),
    message:
        "scenes for other code"


rule ship_statistics:
    input:
        statistics="results/statistics.nc",
    output:
        data="results/shipped/reference_flight.nc",
    log:
        "logs/ship_statistics.log",
    benchmark:
        "results/benchmarks/ship_statistics/all.tsv"
    message:
        "statistics in the form in which they come with the package"
    script:
        "../scripts/ship_statistics.py"
