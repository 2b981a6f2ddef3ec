# The flight beside what was made of its statistics: labels, and PHY's renders of them.


rule tabulate_validation:
    input:
        summaries=SUMMARIES,
        statistics="results/statistics.nc",
        zones=LABEL_STATISTICS,
        rendered=f"results/closed_loop/{LOOP_DEFAULT}_all.nc",
        label_layers="results/tables/label_layers.csv",
        label_histograms="results/tables/label_histograms.csv",
        code=imported_by("tabulate_validation.py"),
    output:
        thickness="results/tables/validation_thickness.csv",
        tests="results/tables/validation_tests.csv",
        distributions="results/tables/validation_distributions.csv",
        superposition="results/tables/superposition.csv",
    log:
        "logs/tabulate_validation.log",
    benchmark:
        "results/benchmarks/tabulate_validation/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        seed=config["seed"],
    message:
        "distributions of the flight beside labels and renders"
    script:
        "../scripts/tabulate_validation.py"


rule validation:
    input:
        rules.tabulate_validation.output,
        *figure_files("closed_loop"),
    message:
        "the flight beside what was made of its statistics"
