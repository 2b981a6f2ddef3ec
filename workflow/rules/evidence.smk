# What the paper claims of renders and of tracked power, measured; scenes for the report's gallery.


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


rule plot_renders:
    input:
        positions="results/tables/render_positions.csv",
        textures="results/tables/render_texture.csv",
        code=imported_by("plot_renders.py"),
    output:
        positions=report(
            "results/figures/render_positions.svg",
            caption="../report/render_positions.rst",
        ),
        textures=report(
            "results/figures/render_texture.svg",
            caption="../report/render_texture.rst",
        ),
    log:
        "logs/plot_renders.log",
    benchmark:
        "results/benchmarks/plot_renders/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        source=NOTE,
    message:
        "figures of positions and texture in renders"
    script:
        "../scripts/plot_renders.py"


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


rule make_gallery:
    input:
        observed=benchmark_files("test"),
        cgan=rendered_files("cgan", "test"),
        phy=rendered_files("phy", "test"),
        images="results/similarity.parquet",
        statistics="results/statistics.nc",
        code=imported_by("make_gallery.py"),
    output:
        gallery="results/gallery.json",
    log:
        "logs/make_gallery.log",
    benchmark:
        "results/benchmarks/make_gallery/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        n_scenes=16,
        source=NOTE,
    message:
        "test scenes for the report's gallery"
    script:
        "../scripts/make_gallery.py"


rule evidence:
    input:
        rules.compare_renders.output,
        rules.plot_renders.output,
        rules.tabulate_tracked_power.output,
        rules.make_gallery.output,
    message:
        "evidence on the paper's claims, scenes for the gallery"
