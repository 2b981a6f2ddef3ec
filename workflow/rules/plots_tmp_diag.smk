# Plot rules of diagnostics and studies as they were, until figures.smk draws them.


SMRT_TABLE = "results/studies/convolution/smrt.csv"


rule plot_closed_loop:
    input:
        table="results/tables/closed_loop.csv",
        conventions="results/tables/closed_loop_conventions.csv",
        code=imported_by("plot_closed_loop.py"),
    output:
        figure=report(
            "results/figures/closed_loop.svg", caption="../report/closed_loop.rst"
        ),
    log:
        "logs/plot_closed_loop.log",
    benchmark:
        "results/benchmarks/plot_closed_loop/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        source=NOTE,
    message:
        "figure of the closed loop"
    script:
        "../scripts/plot_closed_loop.py"


rule plot_validation:
    input:
        thickness="results/tables/validation_thickness.csv",
        tests="results/tables/validation_tests.csv",
        distributions="results/tables/validation_distributions.csv",
        superposition="results/tables/superposition.csv",
        spectra="results/tables/label_spectra.csv",
        correlation="results/tables/label_correlation.csv",
        loop="results/tables/closed_loop.csv",
        code=imported_by("plot_validation.py"),
    output:
        thickness=report(
            "results/figures/validation_thickness.svg",
            caption="../report/validation_thickness.rst",
        ),
        validation=report(
            "results/figures/validation.svg", caption="../report/validation.rst"
        ),
        superposition=report(
            "results/figures/superposition.svg", caption="../report/superposition.rst"
        ),
    log:
        "logs/plot_validation.log",
    benchmark:
        "results/benchmarks/plot_validation/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        source=NOTE,
    message:
        "figures of the flight beside labels and renders"
    script:
        "../scripts/plot_validation.py"


rule plot_realism:
    input:
        table="results/tables/realism.csv",
        curves="results/tables/realism_curves.csv",
        code=imported_by("plot_realism.py"),
    output:
        figure=report("results/figures/realism.svg", caption="../report/realism.rst"),
    log:
        "logs/plot_realism.log",
    benchmark:
        "results/benchmarks/plot_realism/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        source=NOTE,
    message:
        "figure of flight and published values"
    script:
        "../scripts/plot_realism.py"


rule plot_phy_charts:
    input:
        waveforms="results/tables/speed_accuracy_waveforms.csv",
        speckle="results/tables/speed_accuracy_speckle.csv",
        scenes="results/tables/speed_accuracy_scenes.csv",
        growth="results/tables/speed_accuracy_growth.csv",
        code=imported_by("plot_phy_charts.py"),
    output:
        waveforms=report(
            "results/figures/speed_accuracy_waveforms.svg",
            caption="../report/speed_accuracy_waveforms.rst",
        ),
        speckle=report(
            "results/figures/speed_accuracy_speckle.svg",
            caption="../report/speed_accuracy_speckle.rst",
        ),
        scenes=report(
            "results/figures/speed_accuracy_scenes.svg",
            caption="../report/speed_accuracy_scenes.rst",
        ),
        growth=report(
            "results/figures/speed_accuracy_growth.svg",
            caption="../report/speed_accuracy_growth.rst",
        ),
    log:
        "logs/plot_phy_charts.log",
    benchmark:
        "results/benchmarks/plot_phy_charts/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    message:
        "figures of PHY's speed and accuracy"
    script:
        "../scripts/plot_phy_charts.py"


rule plot_phy_plan:
    input:
        plans="results/phy_plans.parquet",
        code=imported_by("plot_phy_plan.py"),
    output:
        figure=report("results/figures/phy_plan.svg", caption="../report/phy_plan.rst"),
    log:
        "logs/plot_phy_plan.log",
    benchmark:
        "results/benchmarks/plot_phy_plan/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        source=NOTE,
    message:
        "figure of what plans left out"
    script:
        "../scripts/plot_phy_plan.py"


rule plot_phy_stability:
    input:
        atlas="results/tables/stability_phy.csv",
        code=imported_by("plot_phy_stability.py"),
    output:
        figure=report(
            "results/figures/stability_phy.svg", caption="../report/stability_phy.rst"
        ),
    log:
        "logs/plot_phy_stability.log",
    benchmark:
        "results/benchmarks/plot_phy_stability/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    message:
        "figure of the stability atlas"
    script:
        "../scripts/plot_phy_stability.py"


rule plot_statistics_stability:
    input:
        atlas="results/tables/stability_statistics.csv",
        code=imported_by("plot_statistics_stability.py"),
    output:
        sweeps=report(
            "results/figures/stability_statistics.svg",
            caption="../report/stability_statistics.rst",
        ),
        borders=report(
            "results/figures/stability_statistics_borders.svg",
            caption="../report/stability_statistics_borders.rst",
        ),
    log:
        "logs/plot_statistics_stability.log",
    benchmark:
        "results/benchmarks/plot_statistics_stability/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    message:
        "figures of the estimators' stability atlas"
    script:
        "../scripts/plot_statistics_stability.py"


rule plot_convolution:
    input:
        table="results/tables/convolution_accuracy.csv",
        code=imported_by("plot_convolution.py"),
    output:
        figure=report(
            "results/figures/convolution_accuracy.svg",
            caption="../report/convolution_accuracy.rst",
        ),
    log:
        "logs/plot_convolution.log",
    benchmark:
        "results/benchmarks/plot_convolution/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        source=NOTE,
        studies=finished_study(SMRT_TABLE),
    message:
        "figure of the convolution model's errors and cost"
    script:
        "../scripts/plot_convolution.py"


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


rule plot_study_tracker:
    input:
        ablation="results/studies/tracker/ablation.csv",
        chosen="results/studies/tracker/chosen.csv",
        seeds="results/studies/tracker/seeds.csv",
        speed="results/tables/speed_accuracy_tracker.csv",
        stability="results/studies/tracker/stability.csv",
        code=imported_by("plot_study_tracker.py"),
    output:
        ablation=report(
            "results/figures/tracker_ablation.svg",
            caption="../report/tracker_ablation.rst",
        ),
        seeds=report(
            "results/figures/tracker_seeds.svg", caption="../report/tracker_seeds.rst"
        ),
        speed=report(
            "results/figures/speed_accuracy_tracker.svg",
            caption="../report/speed_accuracy_tracker.rst",
        ),
        stability=report(
            "results/figures/stability_tracker.svg",
            caption="../report/stability_tracker.rst",
        ),
    log:
        "logs/plot_study_tracker.log",
    benchmark:
        "results/benchmarks/plot_study_tracker/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        source=NOTE,
    message:
        "figures of the studies of the tracker"
    script:
        "../scripts/plot_study_tracker.py"


rule study_cgan_plot_stability:
    input:
        table="results/studies/cgan/stability.csv",
        code=imported_by("study_cgan_plot_stability.py"),
    output:
        figure=report(
            "results/figures/stability_cgan.svg",
            caption="../report/stability_cgan.rst",
        ),
    log:
        "logs/study_cgan_plot_stability.log",
    benchmark:
        "results/benchmarks/study_cgan_plot_stability/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        source=NOTE,
    message:
        "figure of the cGAN's stability"
    script:
        "../scripts/study_cgan_plot_stability.py"


rule study_cgan_plot_widths:
    input:
        table="results/studies/cgan/widths.csv",
        code=imported_by("study_cgan_plot_widths.py"),
    output:
        figure=report(
            "results/figures/speed_accuracy_cgan.svg",
            caption="../report/speed_accuracy_cgan.rst",
        ),
    log:
        "logs/study_cgan_plot_widths.log",
    benchmark:
        "results/benchmarks/study_cgan_plot_widths/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    params:
        source=NOTE,
    message:
        "figure of the cGAN's speed and similarity by width"
    script:
        "../scripts/study_cgan_plot_widths.py"
