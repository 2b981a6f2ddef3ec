# Figures: x.svg is the output x_svg of its rule, whose script of the same name draws it. Its caption is captions/x.rst.

# Label sets to choose the shown ones from: in the first shards, whatever their size.
N_SHOWN = 100


rule plot_flight:
    input:
        statistics="results/statistics.nc",
        code=imported_by(EVALUATION / "plot_flight.py"),
    output:
        **drawn("flight", "waveforms.svg", "along_track.svg"),
    log:
        "logs/plot_flight.log",
    benchmark:
        "results/benchmarks/plot_flight/all.tsv"
    params:
        source=NOTE,
    message:
        "figures of the flight's statistics"
    script:
        "../scripts/plot_flight.py"


rule plot_frames:
    input:
        frame=middle_frame("results/flight/{frame}.nc"),
        picks=middle_frame("results/flight/{frame}_layers.nc"),
        frames=flight_files("results/flight/{frame}.nc"),
        frame_picks=flight_files("results/flight/{frame}_layers.nc"),
        code=imported_by(EVALUATION / "plot_frames.py"),
    output:
        **drawn("flight", "echogram.svg", "flight_line.svg", "pixel_grid.svg"),
        flight_table="results/tables/flight.csv",
        pixel_table="results/tables/pixel_grid.csv",
    log:
        "logs/plot_frames.log",
    benchmark:
        "results/benchmarks/plot_frames/all.tsv"
    params:
        source=NOTE,
    message:
        "figures of the flight's frames"
    script:
        "../scripts/plot_frames.py"


rule plot_labels:
    input:
        label_models=tables(
            "model_selection", "model_selection_scenes", "model_selection_spectra"
        ),
        labels=tables(
            "label_layers", "label_moments", "label_spectra", "label_correlation"
        ),
        code=imported_by(EVALUATION / "plot_labels.py"),
    output:
        **drawn("labels", "label_models.svg", "labels.svg"),
    log:
        "logs/plot_labels.log",
    benchmark:
        "results/benchmarks/plot_labels/all.tsv"
    params:
        source=NOTE,
    message:
        "figures of the label sets"
    script:
        "../scripts/plot_labels.py"


rule plot_renders:
    input:
        losses="results/cgan/losses.csv",
        validation="results/cgan/validation.csv",
        samples="results/cgan/samples.nc",
        train=benchmark_files("train"),
        test=benchmark_files("test"),
        phy=expand("results/phy/labels/{shard}.nc", shard=first_shards(N_SHOWN)),
        cgan=expand("results/cgan/labels/{shard}.nc", shard=first_shards(N_SHOWN)),
        code=imported_by(EVALUATION / "plot_renders.py"),
    output:
        **drawn(
            "renders",
            "cgan_losses.svg",
            "cgan_samples.png",
            "annotation.svg",
            "synthetic.svg",
        ),
    log:
        "logs/plot_renders.log",
    benchmark:
        "results/benchmarks/plot_renders/all.tsv"
    params:
        source=NOTE,
        n_labels=N_SHOWN,
    message:
        "figures of the renders of label sets"
    script:
        "../scripts/plot_renders.py"


rule plot_similarity:
    input:
        render_positions=tables("render_positions"),
        images="results/similarity.parquet",
        ssim_depth=tables("ssim_depth"),
        observed=benchmark_files("test"),
        cgan=rendered_files("cgan", "test"),
        phy=rendered_files("phy", "test"),
        similarity_bounds=tables("similarity_bounds", "similarity_parts", "air_texture"),
        worth=tables("two_sample", "drawn_scenes"),
        code=imported_by(EVALUATION / "plot_similarity.py"),
    output:
        **drawn(
            "similarity",
            "render_positions.svg",
            "similarity_boxplots.svg",
            "ssim_depth.svg",
            "sample.svg",
            "similarity_bounds.svg",
            "worth.svg",
        ),
    log:
        "logs/plot_similarity.log",
    benchmark:
        "results/benchmarks/plot_similarity/all.tsv"
    params:
        source=NOTE,
    message:
        "figures of similarity"
    script:
        "../scripts/plot_similarity.py"


rule plot_tracker:
    input:
        picks=tables("picks", "picks_by_depth"),
        table3_zones=tables("table3_zones"),
        samples="results/tracker/samples.nc",
        precision_recall=tables("precision_recall"),
        table3=tables("table3_intervals"),
        losses=expand(
            "results/tracker/{training_set}/0_losses.csv", training_set=TRAINING_SETS
        ),
        code=imported_by(EVALUATION / "plot_tracker.py"),
    output:
        **drawn(
            "tracker",
            "picks.svg",
            "table3_zones.svg",
            "side_outputs.png",
            "precision_recall.svg",
            "table3.svg",
            "tracker_losses.svg",
        ),
    log:
        "logs/plot_tracker.log",
    benchmark:
        "results/benchmarks/plot_tracker/all.tsv"
    params:
        source=NOTE,
    message:
        "figures of the trackers"
    script:
        "../scripts/plot_tracker.py"


rule plot_closed_loop:
    input:
        closed_loop=tables("closed_loop", "closed_loop_conventions"),
        validation_thickness=tables("validation_thickness", "validation_tests"),
        validation=tables(
            "validation_distributions",
            "validation_thickness",
            "validation_tests",
            "label_spectra",
            "label_correlation",
            "closed_loop",
        ),
        superposition=tables("superposition"),
        code=imported_by(EVALUATION / "plot_closed_loop.py"),
    output:
        **drawn(
            "closed_loop",
            "closed_loop.svg",
            "validation_thickness.svg",
            "validation.svg",
            "superposition.svg",
        ),
    log:
        "logs/plot_closed_loop.log",
    benchmark:
        "results/benchmarks/plot_closed_loop/all.tsv"
    params:
        source=NOTE,
    message:
        "figures of the closed loop and of the validation"
    script:
        "../scripts/plot_closed_loop.py"


rule charts:
    input:
        rules.plot_flight.output,
        rules.plot_frames.output if FRAMES else [],
    message:
        "figures of the flight and of its statistics"
