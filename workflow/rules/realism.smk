# The flight and the benchmark beside what is published of real echograms.


rule tabulate_realism:
    input:
        echograms=flight_files("results/flight/{frame}.nc"),
        layers=flight_files("results/flight/{frame}_layers.nc"),
        statistics="results/statistics.nc",
        train=benchmark_files("train"),
        test=benchmark_files("test"),
        other_band=other_band_images(),
        code=imported_by("tabulate_realism.py"),
    output:
        table="results/tables/realism.csv",
        curves="results/tables/realism_curves.csv",
    log:
        "logs/tabulate_realism.log",
    benchmark:
        "results/benchmarks/tabulate_realism/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        reference=config["reference"],
        source=NOTE,
        seed=config["seed"],
    message:
        "flight and benchmark beside published values"
    script:
        "../scripts/tabulate_realism.py"


rule plot_realism:
    input:
        table="results/tables/realism.csv",
        curves="results/tables/realism_curves.csv",
        code=imported_by("plot_realism.py"),
    output:
        figure=report("results/figures/realism.svg", caption="../report/realism.rst"),
    log:
        "logs/plot_realism.log",
    benchmark:
        "results/benchmarks/plot_realism/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        source=NOTE,
    message:
        "figure of flight and published values"
    script:
        "../scripts/plot_realism.py"


rule realism:
    input:
        rules.tabulate_realism.output,
        rules.plot_realism.output,
    message:
        "how real the flight and the benchmark look"
