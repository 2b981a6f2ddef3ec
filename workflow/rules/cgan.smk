# The conditional GAN: train on the benchmark's train scenes, render layers.


rule train_cgan:
    input:
        train=benchmark_files("train"),
        code=package("cgan", "patches", "weights", "io.files", "io.models", "io.scenes"),
    output:
        generator="results/cgan/generator.safetensors",
        losses="results/cgan/losses.csv",
    log:
        "logs/train_cgan.log",
    benchmark:
        "results/benchmarks/train_cgan/all.tsv"
    priority: 100  # the longest chain of the workflow starts here
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=3000,
        gpu=int(config["cgan"]["device"] == "cuda"),
    params:
        seed=config["seed"],
        device=config["cgan"]["device"],
        settings=config["cgan"]["training"],
    message:
        "cGAN training"
    script:
        "../scripts/train_cgan.py"


rule render_cgan:
    input:
        layers=layers_of,
        generator="results/cgan/generator.safetensors",
        code=package("cgan", "patches", "weights", "io.files", "io.models", "io.scenes"),
    output:
        scenes="results/cgan/{scenes}/{shard}.nc",
    log:
        "logs/render_cgan/{scenes}/{shard}.log",
    benchmark:
        "results/benchmarks/render_cgan/{scenes}/{shard}.tsv"
    priority: 90
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=3000,
        gpu=int(config["cgan"]["device"] == "cuda"),
    params:
        seed=config["seed"],
        device=config["cgan"]["device"],
        source=SYNTHETIC,
    message:
        "cGAN renders of {wildcards.scenes}, shard {wildcards.shard}"
    script:
        "../scripts/render_cgan.py"
