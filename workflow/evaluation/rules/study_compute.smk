# The study of compute: what more scenes, wider networks and longer trainings buy with PHY's scenes alone, which no
# annotation can follow. Each row of studies.compute is one training on the default flight, scored on validation scenes.

COMPUTED = config["studies"]["compute"]
COMPUTED_AS = "results/studies/compute/{n_drawn}/width_{width}/{n_gradients}"


wildcard_constraints:
    n_drawn=r"\d+",
    width=r"\d+",


use rule draw_labels as draw_more with:
    output:
        labels="results/studies/compute/{n_drawn}/labels/{shard}.nc",
    log:
        "logs/draw_more/{n_drawn}/{shard}.log",
    benchmark:
        "results/benchmarks/draw_more/{n_drawn}/{shard}.tsv"
    resources:
        results_mb=lambda w: drawn_mb(w, 18),
    params:
        span=lambda w: drawn_range(w),
    message:
        "{wildcards.n_drawn} label sets, shard {wildcards.shard}"


use rule render_phy as render_more with:
    input:
        layers=rules.draw_more.output.labels,
        statistics="results/statistics.nc",
    output:
        scenes="results/studies/compute/{n_drawn}/phy/{shard}.nc",
    log:
        "logs/render_more/{n_drawn}/{shard}.log",
    benchmark:
        "results/benchmarks/render_more/{n_drawn}/{shard}.tsv"
    resources:
        results_mb=lambda w: drawn_mb(w, 220),
    message:
        "PHY renders of {wildcards.n_drawn} label sets, shard {wildcards.shard}"


use rule train_tracker as train_more with:
    input:
        real=[],
        phy=lambda w: expand(
            rules.render_more.output.scenes,
            n_drawn=w.n_drawn,
            shard=numbered(math.ceil(int(w.n_drawn) / SHARD_SIZE["labels"])),
        ),
        cgan=[],
        own=[],
    output:
        network=f"{COMPUTED_AS}/0.safetensors",
        losses=f"{COMPUTED_AS}/0_losses.csv",
    log:
        "logs/train_more/{n_drawn}/{width}/{n_gradients}.log",
    benchmark:
        "results/benchmarks/train_more/{n_drawn}/{width}/{n_gradients}.tsv"
    params:
        n_epochs=None,
        replica="0",
        settings=lambda w: TRACKER["training"]
        | {"n_steps": int(w.n_gradients), "width": int(w.width)},
        checkpoint=f"{CHECKPOINTS}/compute_{{n_drawn}}_{{width}}_{{n_gradients}}.safetensors",
        events=f"{EVENTS}/train_more/{{n_drawn}}/{{width}}/{{n_gradients}}",
    message:
        "tracker of width {wildcards.width} on {wildcards.n_drawn} scenes, {wildcards.n_gradients} gradients"


use rule score_studied as score_more with:
    input:
        networks=[rules.train_more.output.network],
        scenes=benchmark_files("validation"),
        validation=benchmark_files("validation"),
    output:
        scores=f"{COMPUTED_AS}/scores.csv",
        depths=f"{COMPUTED_AS}/depths.csv",
    log:
        "logs/score_more/{n_drawn}/{width}/{n_gradients}.log",
    benchmark:
        "results/benchmarks/score_more/{n_drawn}/{width}/{n_gradients}.tsv"
    params:
        labels=lambda w: {
            "n_scenes": int(w.n_drawn),
            "width": int(w.width),
            "n_gradients": int(w.n_gradients),
        },
    message:
        "edge scores of width {wildcards.width}, {wildcards.n_drawn} scenes, {wildcards.n_gradients} gradients"


use rule score_flight as tabulate_compute with:
    input:
        scores=[
            f"results/studies/compute/{row['n_scenes']}/width_{row['width']}/{row['n_gradients']}/scores.csv"
            for row in COMPUTED
        ],
        depths=[
            f"results/studies/compute/{row['n_scenes']}/width_{row['width']}/{row['n_gradients']}/depths.csv"
            for row in COMPUTED
        ],
    output:
        scores="results/studies/compute.csv",
        depths="results/studies/compute_depths.csv",
    log:
        "logs/tabulate_compute.log",
    benchmark:
        "results/benchmarks/tabulate_compute/all.tsv"
    message:
        "edge scores by number of scenes, width and gradients"


rule study_compute:
    input:
        rules.tabulate_compute.output,
    message:
        "worth of more compute with PHY's scenes alone: 2 hours of one core"
