# What the paper claims of renders and of tracked power, measured.


rule compare_renders:
    input:
        observed=benchmark_files("test"),
        cgan=rendered_files("cgan", "test"),
        phy=rendered_files("phy", "test"),
        code=imported_by("compare_renders.py"),
    output:
        positions="results/tables/render_positions.csv",
        textures="results/tables/render_texture.csv",
    log:
        "logs/compare_renders.log",
    benchmark:
        "results/benchmarks/compare_renders/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    message:
        "positions of layers and texture in renders of test masks"
    script:
        "../scripts/compare_renders.py"


rule tabulate_tracked_power:
    input:
        statistics="results/statistics.nc",
        code=imported_by("tabulate_tracked_power.py"),
    output:
        table="results/tables/tracked_power.csv",
    log:
        "logs/tabulate_tracked_power.log",
    benchmark:
        "results/benchmarks/tabulate_tracked_power/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=500,
    message:
        "tracked peak power beside the Gamma law"
    script:
        "../scripts/tabulate_tracked_power.py"


rule evidence:
    input:
        rules.compare_renders.output,
        rules.tabulate_tracked_power.output,
    message:
        "evidence on the paper's claims"
