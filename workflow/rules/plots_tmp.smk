# Rules of the old files that other files take over.

ZONE_COUNTS = [1, 2, 3, 4, 6, 8]


rule compare_label_models:
    input:
        summaries=SUMMARIES,
        statistics="results/statistics.nc",
        code=imported_by("compare_label_models.py"),
    output:
        model="results/label_model.nc",
        criteria="results/tables/label_criteria.csv",
        savings="results/tables/label_savings.csv",
        spectra="results/tables/label_families.csv",
        seconds="results/tables/speed_accuracy_labels.csv",
    log:
        "logs/compare_label_models.log",
    benchmark:
        "results/benchmarks/compare_label_models/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        seed=config["seed"],
        n_zones=config["labels"]["n_zones"],
        psd=config["labels"]["psd"],
        zone_counts=ZONE_COUNTS,
        n_range_lines=config["labels"]["n_range_lines"],
        n_scenes=min(300, config["labels"]["n_scenes"]),
    message:
        "label models with fewer parameters, and what they save"
    script:
        "../scripts/compare_label_models.py"


rule plot_label_models:
    input:
        criteria="results/tables/label_criteria.csv",
        savings="results/tables/label_savings.csv",
        spectra="results/tables/label_families.csv",
        code=imported_by("plot_label_models.py"),
    output:
        figure=report(
            "results/figures/label_models.svg", caption="../report/label_models.rst"
        ),
    log:
        "logs/plot_label_models.log",
    benchmark:
        "results/benchmarks/plot_label_models/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        source=NOTE,
    message:
        "figure of label models"
    script:
        "../scripts/plot_label_models.py"


rule plot_labels:
    input:
        layers="results/tables/label_layers.csv",
        moments="results/tables/label_moments.csv",
        spectra="results/tables/label_spectra.csv",
        correlation="results/tables/label_correlation.csv",
        code=imported_by("plot_labels.py"),
    output:
        figure=report("results/figures/labels.svg", caption="../report/labels.rst"),
    log:
        "logs/plot_labels.log",
    benchmark:
        "results/benchmarks/plot_labels/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        source=NOTE,
    message:
        "figure of the label sets"
    script:
        "../scripts/plot_labels.py"


rule plot_cgan_training:
    input:
        losses="results/cgan/losses.csv",
        validation="results/cgan/validation.csv",
        samples="results/cgan/samples.nc",
        code=imported_by("plot_cgan_training.py"),
    output:
        losses=report(
            "results/figures/cgan_losses.svg", caption="../report/cgan_losses.rst"
        ),
        samples=report(
            "results/figures/cgan_samples.png", caption="../report/cgan_samples.rst"
        ),
    log:
        "logs/plot_cgan_training.log",
    benchmark:
        "results/benchmarks/plot_cgan_training/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        source=NOTE,
    message:
        "losses and sample sheet of the cGAN"
    script:
        "../scripts/plot_cgan_training.py"


rule plot_similarity:
    input:
        images="results/similarity.parquet",
        ssim_depth="results/tables/ssim_depth.csv",
        code=imported_by("plot_similarity.py"),
    output:
        boxplots=report(
            "results/figures/similarity_boxplots.svg",
            caption="../report/similarity_boxplots.rst",
        ),
        ssim_depth=report(
            "results/figures/ssim_depth.svg", caption="../report/ssim_depth.rst"
        ),
    log:
        "logs/plot_similarity.log",
    benchmark:
        "results/benchmarks/plot_similarity/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        source=NOTE,
    message:
        "figures of similarity"
    script:
        "../scripts/plot_similarity.py"


rule plot_sample:
    input:
        observed=benchmark_files("test"),
        cgan=rendered_files("cgan", "test"),
        phy=rendered_files("phy", "test"),
        images="results/similarity.parquet",
        code=imported_by("plot_sample.py"),
    output:
        sample=report("results/figures/sample.svg", caption="../report/sample.rst"),
    log:
        "logs/plot_sample.log",
    benchmark:
        "results/benchmarks/plot_sample/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        source=NOTE,
    message:
        "observed, labels, cGAN, PHY of a few test scenes"
    script:
        "../scripts/plot_sample.py"


rule explain_similarity:
    input:
        observed=benchmark_files("test"),
        cgan=rendered_files("cgan", "test"),
        phy=rendered_files("phy", "test"),
        train=benchmark_files("train"),
        generator="results/cgan/generator.safetensors",
        statistics="results/statistics.nc",
        code=imported_by("explain_similarity.py"),
    output:
        bounds="results/tables/similarity_bounds.csv",
        parts="results/tables/similarity_parts.csv",
    log:
        "logs/explain_similarity.log",
    benchmark:
        "results/benchmarks/explain_similarity/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=2000,
        gpu=int(config["cgan"]["device"] == "cuda"),
    params:
        seed=config["seed"],
        n_looks=config["benchmark"]["n_looks"],
        statistics=config["cgan"]["statistics"],
        phy=config["phy"],
        validation=config["cgan"]["validation"],
        device=config["cgan"]["device"],
    message:
        "bounds of similarity and what keeps renders from them"
    script:
        "../scripts/explain_similarity.py"


rule measure_air:
    input:
        observed=benchmark_files("test"),
        cgan=rendered_files("cgan", "test"),
        phy=rendered_files("phy", "test"),
        code=imported_by("measure_air.py"),
    output:
        table="results/tables/air_texture.csv",
    log:
        "logs/measure_air.log",
    benchmark:
        "results/benchmarks/measure_air/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    message:
        "texture above the snow surface"
    script:
        "../scripts/measure_air.py"


rule plot_similarity_bounds:
    input:
        bounds="results/tables/similarity_bounds.csv",
        parts="results/tables/similarity_parts.csv",
        air="results/tables/air_texture.csv",
        code=imported_by("plot_similarity_bounds.py"),
    output:
        figure=report(
            "results/figures/similarity_bounds.svg",
            caption="../report/similarity_bounds.rst",
        ),
    log:
        "logs/plot_similarity_bounds.log",
    benchmark:
        "results/benchmarks/plot_similarity_bounds/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        source=NOTE,
    message:
        "figure of the bounds of similarity"
    script:
        "../scripts/plot_similarity_bounds.py"


rule plot_picks:
    input:
        picks="results/tables/picks.csv",
        depths="results/tables/picks_by_depth.csv",
        zones="results/tables/table3_zones.csv",
        samples="results/tracker/samples.nc",
        code=imported_by("plot_picks.py"),
    output:
        picks=report("results/figures/picks.svg", caption="../report/picks.rst"),
        zones=report(
            "results/figures/table3_zones.svg", caption="../report/table3_zones.rst"
        ),
        sheet=report(
            "results/figures/side_outputs.png", caption="../report/side_outputs.rst"
        ),
    log:
        "logs/plot_picks.log",
    benchmark:
        "results/benchmarks/plot_picks/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        source=NOTE,
    message:
        "figures of picks and side outputs"
    script:
        "../scripts/plot_picks.py"


rule plot_trackers:
    input:
        curves="results/tables/precision_recall.csv",
        intervals="results/tables/table3_intervals.csv",
        losses=expand(
            "results/tracker/{training_set}/0_losses.csv", training_set=TRAINING_SETS
        ),
        code=imported_by("plot_trackers.py"),
    output:
        curves=report(
            "results/figures/precision_recall.svg",
            caption="../report/precision_recall.rst",
        ),
        scores=report("results/figures/table3.svg", caption="../report/table3.rst"),
        losses=report(
            "results/figures/tracker_losses.svg",
            caption="../report/tracker_losses.rst",
        ),
    log:
        "logs/plot_trackers.log",
    benchmark:
        "results/benchmarks/plot_trackers/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        training_sets=list(TRAINING_SETS),
        source=NOTE,
    message:
        "figures of the trackers"
    script:
        "../scripts/plot_trackers.py"
