# Counterparts of figures of the paper that show single scenes: pixel grid, annotation, synthetic layers and their renders.


rule plot_pixel_grid:
    input:
        echogram=middle_frame("results/flight/{frame}.nc"),
        layers=middle_frame("results/flight/{frame}_layers.nc"),
        code=imported_by("plot_pixel_grid.py"),
    output:
        table="results/tables/pixel_grid.csv",
        figure=report(
            "results/figures/pixel_grid.svg", caption="../report/pixel_grid.rst"
        ),
    log:
        "logs/plot_pixel_grid.log",
    benchmark:
        "results/benchmarks/plot_pixel_grid/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        source=NOTE,
    message:
        "pixel grid of four range lines and three layers"
    script:
        "../scripts/plot_pixel_grid.py"


rule plot_annotation:
    input:
        train=benchmark_files("train"),
        code=imported_by("plot_annotation.py"),
    output:
        figure=report(
            "results/figures/annotation.svg", caption="../report/annotation.rst"
        ),
    log:
        "logs/plot_annotation.log",
    benchmark:
        "results/benchmarks/plot_annotation/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        source=NOTE,
    message:
        "a train scene, what a picker annotates, all there is"
    script:
        "../scripts/plot_annotation.py"


# Label sets that the figure chooses from, and the files that hold them: what it shows does not depend on shards.
LABELS_TO_SHOW = 100
SHARDS_TO_SHOW = [
    shard
    for shard in shards("labels")
    if shard_range("labels", shard)[0] < LABELS_TO_SHOW
]


rule plot_synthetic:
    input:
        labels=expand("results/labels/{shard}.nc", shard=SHARDS_TO_SHOW),
        phy=expand("results/phy/labels/{shard}.nc", shard=SHARDS_TO_SHOW),
        cgan=expand("results/cgan/labels/{shard}.nc", shard=SHARDS_TO_SHOW),
        code=imported_by("plot_synthetic.py"),
    output:
        figure=report(
            "results/figures/synthetic.svg", caption="../report/synthetic.rst"
        ),
    log:
        "logs/plot_synthetic.log",
    benchmark:
        "results/benchmarks/plot_synthetic/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        source=NOTE,
        n_labels=LABELS_TO_SHOW,
    message:
        "synthetic layers and both renders of them"
    script:
        "../scripts/plot_synthetic.py"


rule paper_figures:
    input:
        # Where the flight's echogram can be drawn, so can its pixels.
        *[
            file
            for file in rules.plot_pixel_grid.output
            if rules.plot_flight.output.echogram in list(rules.charts.input)
        ],
        rules.plot_annotation.output,
        rules.plot_synthetic.output,
    message:
        "counterparts of figures of the paper that show single scenes"
