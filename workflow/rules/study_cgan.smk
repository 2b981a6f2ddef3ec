# Studies of the conditional GAN: spread over seeds, speed against similarity, stability. Not part of the default run:
# snakemake study_cgan. Trainings of the default are those of train_cgan itself.

CGAN_STUDY = config["studies"]["cgan"]
CGAN_TRAINING = config["cgan"]["training"]
CGAN_SEEDS = [config["seed"] + number for number in range(1, CGAN_STUDY["n_seeds"])]
CGAN_MODES = ("equal_steps", "equal_time")
CGAN_PARTS = (
    "cgan",
    "metrics.image",
    "patches",
    "weights",
    "io.files",
    "io.models",
    "io.scenes",
)


wildcard_constraints:
    cgan_seed=r"\d+",
    cgan_width=r"\d+",
    cgan_mode="|".join(CGAN_MODES),


rule study_cgan_seed:
    input:
        train=benchmark_files("train"),
        code=imported_by("train_cgan.py"),
    output:
        generator="results/studies/cgan/seed_{cgan_seed}/generator.safetensors",
        losses="results/studies/cgan/seed_{cgan_seed}/losses.csv",
        validation="results/studies/cgan/seed_{cgan_seed}/validation.csv",
        samples="results/studies/cgan/seed_{cgan_seed}/samples.nc",
    log:
        "logs/study_cgan_seed/{cgan_seed}.log",
    benchmark:
        "results/benchmarks/study_cgan_seed/{cgan_seed}.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=3000,
        gpu=int(config["cgan"]["device"] == "cuda"),
    params:
        seed=lambda wildcards: int(wildcards.cgan_seed),
        device=config["cgan"]["device"],
        settings=CGAN_TRAINING,
        statistics=config["cgan"]["statistics"],
        validation=config["cgan"]["validation"],
        on_collapse=config["cgan"]["on_collapse"],
        source=SYNTHETIC,
        checkpoint="results/checkpoints/study_cgan_seed/{cgan_seed}.safetensors",
        checkpoint_steps=config["checkpoints"]["every_steps"],
        events="logs/tensorboard/study_cgan_seed/{cgan_seed}",
    message:
        "cGAN training with seed {wildcards.cgan_seed}"
    script:
        "../scripts/train_cgan.py"


rule study_cgan_score:
    input:
        observed=benchmark_files("test"),
        generator="results/studies/cgan/seed_{cgan_seed}/generator.safetensors",
        code=imported_by("study_cgan_score.py"),
    output:
        images="results/studies/cgan/seed_{cgan_seed}/similarity.parquet",
    log:
        "logs/study_cgan_score/{cgan_seed}.log",
    benchmark:
        "results/benchmarks/study_cgan_score/{cgan_seed}.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=2000,
        gpu=int(config["cgan"]["device"] == "cuda"),
    params:
        seed=config["seed"],
        device=config["cgan"]["device"],
        statistics=config["cgan"]["statistics"],
    message:
        "similarity of the cGAN of seed {wildcards.cgan_seed}"
    script:
        "../scripts/study_cgan_score.py"


rule study_cgan_tabulate_seeds:
    input:
        default="results/similarity.parquet",
        seeds=expand(
            "results/studies/cgan/seed_{cgan_seed}/similarity.parquet",
            cgan_seed=CGAN_SEEDS,
        ),
        code=imported_by("study_cgan_tabulate_seeds.py"),
    output:
        table="results/studies/cgan/seeds.csv",
    log:
        "logs/study_cgan_tabulate_seeds.log",
    benchmark:
        "results/benchmarks/study_cgan_tabulate_seeds/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=500,
    params:
        seeds=[config["seed"], *CGAN_SEEDS],
    message:
        "spread of Table II over seeds"
    script:
        "../scripts/study_cgan_tabulate_seeds.py"


rule study_cgan_speed:
    input:
        train=benchmark_files("train"),
        statistics="results/statistics.nc",
        code=imported_by("study_cgan_speed.py"),
    output:
        table="results/studies/cgan/speed.csv",
    log:
        "logs/study_cgan_speed.log",
    benchmark:
        "results/benchmarks/study_cgan_speed/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=2000,
    params:
        seed=config["seed"],
        settings=CGAN_TRAINING,
        widths=CGAN_STUDY["widths"],
        n_rounds=CGAN_STUDY["n_rounds"],
        phy=config["phy"],
    message:
        "seconds per step and per render by width"
    script:
        "../scripts/study_cgan_speed.py"


rule study_cgan_width:
    input:
        train=benchmark_files("train"),
        speed="results/studies/cgan/speed.csv",
        code=imported_by("study_cgan_width.py"),
    output:
        generator="results/studies/cgan/{cgan_mode}_{cgan_width}/generator.safetensors",
        losses="results/studies/cgan/{cgan_mode}_{cgan_width}/losses.csv",
        validation="results/studies/cgan/{cgan_mode}_{cgan_width}/validation.csv",
        samples="results/studies/cgan/{cgan_mode}_{cgan_width}/samples.nc",
    log:
        "logs/study_cgan_width/{cgan_mode}_{cgan_width}.log",
    benchmark:
        "results/benchmarks/study_cgan_width/{cgan_mode}_{cgan_width}.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=4000,
    params:
        mode="{cgan_mode}",
        width=lambda wildcards: int(wildcards.cgan_width),
        n_steps=CGAN_STUDY["n_steps"],
        seconds=CGAN_STUDY["seconds"],
        training={
            "seed": config["seed"],
            "device": config["cgan"]["device"],
            "settings": CGAN_TRAINING,
            "statistics": config["cgan"]["statistics"],
            "validation": config["cgan"]["validation"],
            "on_collapse": "go_on",
            "source": SYNTHETIC,
            "checkpoint_steps": config["checkpoints"]["every_steps"],
        },
        checkpoint="results/checkpoints/study_cgan_width/{cgan_mode}_{cgan_width}.safetensors",
        events="logs/tensorboard/study_cgan_width/{cgan_mode}_{cgan_width}",
    message:
        "cGAN training of width {wildcards.cgan_width}, {wildcards.cgan_mode}"
    script:
        "../scripts/study_cgan_width.py"


rule study_cgan_tabulate_widths:
    input:
        speed="results/studies/cgan/speed.csv",
        bounds="results/tables/similarity_bounds.csv",
        validations=expand(
            "results/studies/cgan/{cgan_mode}_{cgan_width}/validation.csv",
            cgan_mode=CGAN_MODES,
            cgan_width=CGAN_STUDY["widths"],
        ),
        code=imported_by("study_cgan_tabulate_widths.py"),
    output:
        table="results/studies/cgan/widths.csv",
    log:
        "logs/study_cgan_tabulate_widths.log",
    benchmark:
        "results/benchmarks/study_cgan_tabulate_widths/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        runs=[(mode, width) for mode in CGAN_MODES for width in CGAN_STUDY["widths"]],
    message:
        "speed and similarity of the cGAN by width"
    script:
        "../scripts/study_cgan_tabulate_widths.py"


rule study_cgan_stability:
    input:
        train=benchmark_files("train"),
        code=imported_by("study_cgan_stability.py"),
    output:
        table="results/studies/cgan/stability.csv",
    log:
        "logs/study_cgan_stability.log",
    benchmark:
        "results/benchmarks/study_cgan_stability/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=2000,
    params:
        seed=config["seed"],
        settings={**CGAN_TRAINING, **CGAN_STUDY["stability"]["training"]},
        statistics=config["cgan"]["statistics"],
        n_held=config["cgan"]["validation"]["n_scenes"],
        n_seeds=CGAN_STUDY["stability"]["n_seeds"],
        learning_rates=CGAN_STUDY["stability"]["learning_rates"],
        l1_weights=CGAN_STUDY["stability"]["l1_weights"],
    message:
        "stability of the cGAN: seeds, rates, L1 weights"
    script:
        "../scripts/study_cgan_stability.py"


rule study_cgan:
    input:
        rules.study_cgan_tabulate_seeds.output,
        rules.study_cgan_tabulate_widths.output,
        rules.study_cgan_stability.output,
        *figure_files("study_cgan"),
    message:
        "studies of the cGAN"
