# Layers -> echograms by the physics-driven renderer.


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
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        seed=config["seed"],
        phy=config["phy"],
    message:
        "PHY renders of {wildcards.scenes}, shard {wildcards.shard}"
    script:
        "../scripts/render_phy.py"


rule renders:
    input:
        *[
            rendered_files(method, scenes)
            for method in METHODS
            for scenes in ("labels", "test")
        ],
        *figure_files("renders"),
    message:
        "label sets and test masks rendered by both methods, and figures of single scenes"
