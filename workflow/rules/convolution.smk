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


rule plot_convolution:
    input:
        table="results/tables/convolution_accuracy.csv",
        code=imported_by("plot_convolution.py"),
    output:
        figure=report(
            "results/figures/convolution_accuracy.svg",
            caption="../report/convolution_accuracy.rst",
        ),
    log:
        "logs/plot_convolution.log",
    benchmark:
        "results/benchmarks/plot_convolution/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        source=NOTE,
        studies=finished_study(SMRT_TABLE),
    message:
        "figure of the convolution model's errors and cost"
    script:
        "../scripts/plot_convolution.py"


rule convolution:
    input:
        rules.measure_convolution.output,
        rules.plot_convolution.output,
    message:
        "how good the convolution model is, and where it stops being good enough"
