# Layers -> echograms: by PHY, the physics-driven renderer, and by the conditional GAN trained on the train scenes.


rule render_phy:
    input:
        layers=layers_of,
        statistics="results/statistics.nc",
        code=imported_by("render_phy.py"),
    output:
        scenes="results/phy/{scenes}/{shard}.nc",
    log:
        "logs/render_phy/{scenes}/{shard}.log",
    benchmark:
        "results/benchmarks/render_phy/{scenes}/{shard}.tsv"
    resources:
        results_mb=lambda wildcards: scenes_mb(wildcards.scenes, wildcards.shard, 220),
    params:
        seed=config["seed"],
        phy=config["phy"],
        by_other_statistics=False,
    message:
        "PHY renders of {wildcards.scenes}, shard {wildcards.shard}"
    script:
        str(SCRIPTS / "render_phy.py")  # absolute, for rules that are made of this one


rule complete_picks:
    input:
        scenes="results/benchmark/train/{shard}.nc",
        weights=str(ROOT / "snowsim/data/universal.onnx"),
        code=imported_by("complete_picks.py"),
    output:
        completed="results/cgan/train/{shard}.nc",
    log:
        "logs/complete_picks/{shard}.log",
    benchmark:
        "results/benchmarks/complete_picks/{shard}.tsv"
    priority: 100
    resources:
        results_mb=lambda wildcards: scenes_mb("train", wildcards.shard, 220),
    params:
        bin_s=(
            config["reference"]["radar"]["bin_size_s"]
            if config["source"] == "reference"
            else config["import"]["bin_s"]
        ),
        source=SYNTHETIC,
    message:
        "layers that picks of train scenes lack, shard {wildcards.shard}"
    script:
        "../scripts/complete_picks.py"


rule train_cgan:
    input:
        scenes=cgan_train_files(),
        code=imported_by("train_cgan.py"),
    output:
        generator="results/cgan/generator.safetensors",
        losses="results/cgan/losses.csv",
        scores="results/cgan/validation.csv",
        samples="results/cgan/samples.nc",
    log:
        "logs/train_cgan.log",
    benchmark:
        "results/benchmarks/train_cgan/all.tsv"
    priority: 100  # the longest chain of the workflow starts here
    resources:
        mem_mb=3000,
        gpu=int(config["cgan"]["device"] == "cuda"),
    params:
        seed=config["seed"],
        device=config["cgan"]["device"],
        settings=CGAN_SETTINGS,
        validation=config["cgan"]["validation"],
        on_collapse=config["cgan"]["on_collapse"],
        source=SYNTHETIC,
        checkpoint=f"{CHECKPOINTS}/train_cgan.safetensors",
        checkpoint_steps=config["checkpoints"]["every_steps"],
        events=f"{EVENTS}/train_cgan",
    message:
        "cGAN training"
    script:
        str(SCRIPTS / "train_cgan.py")  # absolute, for rules that are made of this one


rule render_cgan:
    input:
        layers=layers_of,
        generator="results/cgan/generator.safetensors",
        statistics="results/statistics.nc",
        code=imported_by("render_cgan.py"),
    output:
        scenes="results/cgan/{scenes}/{shard}.nc",
    log:
        "logs/render_cgan/{scenes}/{shard}.log",
    benchmark:
        "results/benchmarks/render_cgan/{scenes}/{shard}.tsv"
    priority: 90
    resources:
        mem_mb=3000,
        results_mb=lambda wildcards: scenes_mb(wildcards.scenes, wildcards.shard, 220),
        gpu=int(config["cgan"]["device"] == "cuda"),
    params:
        seed=config["seed"],
        device=config["cgan"]["device"],
        source=SYNTHETIC,
    message:
        "cGAN renders of {wildcards.scenes}, shard {wildcards.shard}"
    script:
        str(SCRIPTS / "render_cgan.py")  # absolute, for rules that are made of this one


rule renders:
    input:
        rendered_files("cgan", "labels"),
        rendered_files("cgan", "test"),
        rendered_files("phy", "labels"),
        rendered_files("phy", "test"),
    message:
        "label sets and test masks rendered by both methods"
