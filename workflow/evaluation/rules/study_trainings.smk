# Trainings of trackers that studies compare: on which scenes, evaluation/lib/studied.py, and with how many gradients.

from evaluation.lib import flights, studied

REPLICAS = range(config["studies"]["n_trainings"])
REAL_SCENES = {
    None: [],
    "train": benchmark_files("train"),
    "sample": [*benchmark_files("train"), "results/studies/sample_flight.nc"],
    "completed": expand("results/cgan/train/{shard}.nc", shard=shards("train")),
}
ADDED_SCENES = {
    "phy": rendered_files("phy", "labels"),
    "cgan": rendered_files("cgan", "labels"),
    "cgan_as_picked": expand("results/studies/cgan/{shard}.nc", shard=shards("labels")),
}


wildcard_constraints:
    studied=studied.NAMES,
    n_gradients=r"\d+",


rule cut_flight:
    input:
        echograms=expand("results/flight/{frame}.nc", frame=FRAMES),
        layers=expand("results/flight/{frame}_layers.nc", frame=FRAMES),
    output:
        scenes="results/studies/sample_flight.nc",
    log:
        "logs/cut_flight.log",
    benchmark:
        "results/benchmarks/cut_flight/all.tsv"
    params:
        source=SYNTHETIC,
    message:
        "annotated blocks of the sample flight as scenes"
    script:
        "../scripts/cut_flight.py"


# A cGAN that is trained on picks as they are, whatever the configuration says.


use rule train_cgan as train_cgan_as_picked with:
    input:
        scenes=benchmark_files("train"),
    output:
        generator="results/studies/cgan/generator.safetensors",
        losses="results/studies/cgan/losses.csv",
    log:
        "logs/train_cgan_as_picked.log",
    benchmark:
        "results/benchmarks/train_cgan_as_picked/all.tsv"
    params:
        checkpoint=f"{CHECKPOINTS}/train_cgan_as_picked.safetensors",
        events=f"{EVENTS}/train_cgan_as_picked",
    message:
        "cGAN training on picks as they are"


use rule render_cgan as render_cgan_as_picked with:
    input:
        layers="results/labels/{shard}.nc",
        generator=rules.train_cgan_as_picked.output.generator,
        statistics="results/statistics.nc",
    output:
        scenes="results/studies/cgan/{shard}.nc",
    log:
        "logs/render_cgan_as_picked/{shard}.log",
    benchmark:
        "results/benchmarks/render_cgan_as_picked/{shard}.tsv"
    resources:
        mem_mb=3000,
        results_mb=lambda w: scenes_mb("labels", w.shard, 220),
        gpu=int(CGAN["device"] == "cuda"),
    message:
        "renders by the cGAN of picks as they are, shard {wildcards.shard}"


use rule train_tracker as train_studied with:
    input:
        real=lambda w: REAL_SCENES[studied.studied_set(w.studied).real],
        phy=lambda w: ADDED_SCENES["phy"] if "phy" in studied.studied_set(w.studied).added else [],
        cgan=lambda w: [
            path
            for name in studied.studied_set(w.studied).added
            if name != "phy"
            for path in ADDED_SCENES[name]
        ],
        own=[],
    output:
        network="results/studies/{studied}/{n_gradients}/{replica}.safetensors",
        losses="results/studies/{studied}/{n_gradients}/{replica}_losses.csv",
    log:
        "logs/train_studied/{studied}/{n_gradients}/{replica}.log",
    benchmark:
        "results/benchmarks/train_studied/{studied}/{n_gradients}/{replica}.tsv"
    params:
        n_epochs=None,
        data=lambda w: studied.studied_set(w.studied).data,
        settings=lambda w: TRACKER["training"] | {"n_steps": int(w.n_gradients)},
        checkpoint=f"{CHECKPOINTS}/studied_{{studied}}_{{n_gradients}}_{{replica}}.safetensors",
        events=f"{EVENTS}/train_studied/{{studied}}/{{n_gradients}}/{{replica}}",
    message:
        "tracker on {wildcards.studied}, {wildcards.n_gradients} gradients, replica {wildcards.replica}"


rule score_studied:
    input:
        networks=expand(
            "results/studies/{{studied}}/{{n_gradients}}/{replica}.safetensors", replica=REPLICAS
        ),
        scenes=lambda w: benchmark_files(w.split),
        validation=benchmark_files("validation"),
    output:
        scores="results/studies/{studied}/{n_gradients}/{split}_scores.csv",
        depths="results/studies/{studied}/{n_gradients}/{split}_depths.csv",
    log:
        "logs/score_studied/{studied}/{n_gradients}/{split}.log",
    benchmark:
        "results/benchmarks/score_studied/{studied}/{n_gradients}/{split}.tsv"
    resources:
        mem_mb=2000,
    params:
        labels=lambda w: {"training_set": w.studied, "n_gradients": int(w.n_gradients)},
        depth_step_bins=TRACKER["picks"]["depth_step_bins"],
    message:
        "edge scores and picks by depth of {wildcards.studied}, {wildcards.n_gradients} gradients"
    script:
        "../scripts/score_studied.py"
