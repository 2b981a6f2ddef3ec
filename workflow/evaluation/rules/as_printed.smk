# A second run, as printed in the paper: the same flight and benchmark with other choices from statistics to Table III, in
# results/as_printed. Nothing on the way from flight to Table III depends on it; the report shows its tables if there are
# any.

PRINTED_TABLES = [f"results/as_printed/tables/table{n}.csv" for n in (2, 3)]
PRINTED_IS_MADE = all(map(os.path.isfile, PRINTED_TABLES))
PRINTED = deepcopy(GIVEN)
# Sizes of the measured cGAN, not all of which the printed one can have.
for size in ("n_range_bins", "n_range_lines", "depth"):
    PRINTED["cgan"].get("training", {}).pop(size, None)
update_config(PRINTED, yaml.safe_load((ROOT / "config/as_printed.yaml").read_text()))
PRINTED["own"] = {}
PRINTED["checkpoints"]["folder"] = "results/as_printed/checkpoints"
PRINTED["checkpoints"]["events"] = "logs/as_printed/tensorboard"


module printed:
    snakefile:
        str(ROOT / "workflow/rules/main.smk")
    config:
        PRINTED
    # Rules that are not named are shared: frames, their summaries, and the benchmark.
    replace_prefix:
        {
            "logs/": "logs/as_printed/",
            "results/statistics.nc": "results/as_printed/statistics.nc",
            "results/labels/": "results/as_printed/labels/",
            "results/phy/": "results/as_printed/phy/",
            "results/cgan/": "results/as_printed/cgan/",
            "results/similarity": "results/as_printed/similarity",
            "results/tracker/": "results/as_printed/tracker/",
            "results/tables/": "results/as_printed/tables/",
            "results/benchmarks/": "results/as_printed/benchmarks/",
        }


use rule * from printed exclude labels, renders, similarity, trackers as printed_*


rule as_printed:
    input:
        PRINTED_TABLES,
    message:
        "Tables II and III of the paper as printed; the report made next shows them"
