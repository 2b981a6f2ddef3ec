# From layers to echograms, by PHY, the physics-driven renderer, and by the conditional GAN trained on the train scenes.

# Folders of the layers of each scene set.
LAYERS = {"labels": "results/labels", "test": "results/benchmark/test"}
# Train scenes of the cGAN: with layers as picked, or completed by the tracker that comes with the package.
PICKED = {"as_picked": "results/benchmark/train", "completed": "results/cgan/train"}
CGAN = config["cgan"]


rule render_phy:
    input:
        layers=lambda w: f"{LAYERS[w.scenes]}/{w.shard}.nc",
        statistics="results/statistics.nc",
    output:
        scenes="results/phy/{scenes}/{shard}.nc",
    log:
        "logs/render_phy/{scenes}/{shard}.log",
    benchmark:
        "results/benchmarks/render_phy/{scenes}/{shard}.tsv"
    resources:
        results_mb=lambda w: scenes_mb(w.scenes, w.shard, 220),
    params:
        seed=config["seed"],
        phy=config["phy"],
    message:
        "PHY renders of {wildcards.scenes}, shard {wildcards.shard}"
    script:
        str(ROOT / "workflow/scripts/render_phy.py")


rule complete_picks:
    input:
        scenes="results/benchmark/train/{shard}.nc",
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
        tracker=of_checkout("snowsim/data/universal.onnx", "snowsim/data/universal.json"),
        bin_s=BIN_S,
        source=SYNTHETIC,
    message:
        "layers that picks of train scenes lack, shard {wildcards.shard}"
    script:
        "../scripts/complete_picks.py"


rule train_cgan:
    input:
        scenes=expand("{folder}/{shard}.nc", folder=PICKED[CGAN["picks"]], shard=shards("train")),
    output:
        generator="results/cgan/generator.safetensors",
        losses="results/cgan/losses.csv",
    log:
        "logs/train_cgan.log",
    benchmark:
        "results/benchmarks/train_cgan/all.tsv"
    priority: 100  # the longest chain of the workflow starts here
    threads: training_threads(CGAN["device"])
    resources:
        mem_mb=3000,
        gpu=int(CGAN["device"] == "cuda"),
    params:
        seed=config["seed"],
        device=CGAN["device"],
        settings=CGAN["training"],
        checkpoint=f"{CHECKPOINTS}/train_cgan.safetensors",
        checkpoint_steps=config["checkpoints"]["every_steps"],
        events=f"{EVENTS}/train_cgan",
    message:
        "cGAN training"
    script:
        str(ROOT / "workflow/scripts/train_cgan.py")


rule render_cgan:
    input:
        layers=lambda w: f"{LAYERS[w.scenes]}/{w.shard}.nc",
        generator="results/cgan/generator.safetensors",
        statistics="results/statistics.nc",
    output:
        scenes="results/cgan/{scenes}/{shard}.nc",
    log:
        "logs/render_cgan/{scenes}/{shard}.log",
    benchmark:
        "results/benchmarks/render_cgan/{scenes}/{shard}.tsv"
    priority: 90
    resources:
        mem_mb=3000,
        results_mb=lambda w: scenes_mb(w.scenes, w.shard, 220),
        gpu=int(CGAN["device"] == "cuda"),
    params:
        seed=config["seed"],
        device=CGAN["device"],
        source=SYNTHETIC,
    message:
        "cGAN renders of {wildcards.scenes}, shard {wildcards.shard}"
    script:
        str(ROOT / "workflow/scripts/render_cgan.py")


# Renderers of someone's own, functions of a scene. A workflow without any has no such rule.
if OWN_RENDERERS:

    rule render_own:
        input:
            layers=lambda w: f"{LAYERS[w.scenes]}/{w.shard}.nc",
            statistics="results/statistics.nc",
            function=lambda w: OWN_RENDERERS[w.renderer],
        output:
            scenes="results/own/{renderer}/{scenes}/{shard}.nc",
        log:
            "logs/render_own/{renderer}/{scenes}/{shard}.log",
        benchmark:
            "results/benchmarks/render_own/{renderer}/{scenes}/{shard}.tsv"
        wildcard_constraints:
            renderer="|".join(OWN_RENDERERS),
        resources:
            results_mb=lambda w: scenes_mb(w.scenes, w.shard, 220),
        params:
            renderer="{renderer}",
            # An input is compared by its time alone: an older file put back would not be seen.
            function=lambda w: finished([OWN_RENDERERS[w.renderer]]),
        message:
            "renders by {wildcards.renderer} of {wildcards.scenes}, shard {wildcards.shard}"
        script:
            "../scripts/render_own.py"


rule renders:
    input:
        [rendered_files(method, "labels", "test") for method in METHODS],
    message:
        "label sets and test masks rendered by every method"
