# The layer tracker on real data and on three augmented sets, and its edge scores: Table III.


rule train_tracker:
    input:
        real=benchmark_files("train"),
        added=added_scenes,
        code=package(
            "tracker", "patches", "weights", "io.files", "io.models", "io.scenes"
        ),
    output:
        network="results/tracker/{training_set}/{replica}.safetensors",
        losses="results/tracker/{training_set}/{replica}_losses.csv",
    log:
        "logs/train_tracker/{training_set}/{replica}.log",
    benchmark:
        "results/benchmarks/train_tracker/{training_set}/{replica}.tsv"
    priority: 50
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=2000,
        gpu=int(config["tracker"]["device"] == "cuda"),
    params:
        seed=config["seed"],
        device=config["tracker"]["device"],
        n_epochs=config["tracker"]["n_epochs"],
        added_per_real=config["tracker"]["added_per_real"],
        settings=config["tracker"]["training"],
        methods=lambda wildcards: TRAINING_SETS[wildcards.training_set],
    message:
        "tracker on {wildcards.training_set}, replica {wildcards.replica}"
    script:
        "../scripts/train_tracker.py"


rule score_tracker:
    input:
        test=benchmark_files("test"),
        network="results/tracker/{training_set}/{replica}.safetensors",
        code=package(
            "tracker",
            "patches",
            "weights",
            "metrics.edges",
            "io.files",
            "io.models",
            "io.scenes",
        ),
    output:
        counts="results/tracker/{training_set}/{replica}_counts.parquet",
    log:
        "logs/score_tracker/{training_set}/{replica}.log",
    benchmark:
        "results/benchmarks/score_tracker/{training_set}/{replica}.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=2000,
        gpu=int(config["tracker"]["device"] == "cuda"),
    params:
        device=config["tracker"]["device"],
    message:
        "edge scores of {wildcards.training_set}, replica {wildcards.replica}"
    script:
        "../scripts/score_tracker.py"


rule tabulate_trackers:
    input:
        counts=expand(
            "results/tracker/{training_set}/{replica}_counts.parquet",
            training_set=TRAINING_SETS,
            replica=SEEDS,
        ),
        code=package("metrics", "io.files"),
    output:
        table3="results/tables/table3.csv",
        intervals="results/tables/table3_intervals.csv",
        curves="results/tables/precision_recall.csv",
    log:
        "logs/tabulate_trackers.log",
    benchmark:
        "results/benchmarks/tabulate_trackers/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        seed=config["seed"],
        n_bootstrap=config["tracker"]["n_bootstrap"],
        training_sets=list(TRAINING_SETS),
        replicas=SEEDS,
    message:
        "Table III"
    script:
        "../scripts/tabulate_trackers.py"


rule plot_trackers:
    input:
        curves="results/tables/precision_recall.csv",
        intervals="results/tables/table3_intervals.csv",
        losses=expand(
            "results/tracker/{training_set}/0_losses.csv", training_set=TRAINING_SETS
        ),
        code=package("plotting", "io.figures", "io.files"),
    output:
        curves=report(
            "results/figures/precision_recall.svg",
            caption="../report/precision_recall.rst",
        ),
        scores=report("results/figures/table3.svg", caption="../report/table3.rst"),
        losses=report(
            "results/figures/tracker_losses.svg",
            caption="../report/tracker_losses.rst",
        ),
    log:
        "logs/plot_trackers.log",
    benchmark:
        "results/benchmarks/plot_trackers/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        training_sets=list(TRAINING_SETS),
        source=NOTE,
    message:
        "figures of the trackers"
    script:
        "../scripts/plot_trackers.py"


rule trackers:
    input:
        rules.tabulate_trackers.output,
        rules.plot_trackers.output,
    message:
        "Table III and its figures"
