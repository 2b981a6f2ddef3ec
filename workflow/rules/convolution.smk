# How good the convolution model is: against a coherent solver with all multiples, and against off-nadir integrals.

SMRT_TABLE = "results/studies/convolution/smrt.csv"


rule measure_convolution:
    input:
        code=imported_by("measure_convolution.py"),
    output:
        table="results/tables/convolution_accuracy.csv",
    log:
        "logs/measure_convolution.log",
    benchmark:
        "results/benchmarks/measure_convolution/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        reference=config["reference"],
        n_looks=config["benchmark"]["n_looks"],
        seed=config["seed"],
        source=NOTE,
    message:
        "errors and cost of the convolution model"
    script:
        "../scripts/measure_convolution.py"


rule convolution:
    input:
        rules.measure_convolution.output,
        *figure_files("convolution"),
    message:
        "how good the convolution model is, and where it stops being good enough"
