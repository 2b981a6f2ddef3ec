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


rule realism:
    input:
        rules.tabulate_realism.output,
        *figure_files("realism"),
    message:
        "how real the flight and the benchmark look"
