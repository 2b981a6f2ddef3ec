# The sample flight, summaries of its frames, and the benchmark (train, validation and test scenes).


if SOURCE == "reference":

    # Each shard has a rule of its own, since a job takes longer to start than to draw one frame, and a wildcard cannot
    # stand for many outputs.
    for shard, frames in FRAME_SHARDS.items():

        rule:
            name:
                f"reference_frames_{shard}"
            output:
                echograms=expand("results/flight/{frame}.nc", frame=frames),
                layers=expand("results/flight/{frame}_layers.nc", frame=frames),
                segment=SEGMENT if shard == "0000" else [],
            log:
                f"logs/reference_frames/{shard}.log",
            benchmark:
                f"results/benchmarks/reference_frames/{shard}.tsv"
            resources:
                mem_mb=1500,
                results_mb=math.ceil(len(frames) * config["flight"]["n_range_lines"] * 3.7e-3),
            params:
                frames=[int(frame) for frame in frames],
                seed=config["seed"],
                n_frames=config["flight"]["n_frames"],
                n_range_lines=config["flight"]["n_range_lines"],
                reference=config["reference"],
            message:
                f"frames of the synthetic reference flight, shard {shard}"
            script:
                "../scripts/reference_frames.py"

    rule reference_scenes:
        output:
            scenes="results/benchmark/{split}/{shard}.nc",
        log:
            "logs/reference_scenes/{split}/{shard}.log",
        benchmark:
            "results/benchmarks/reference_scenes/{split}/{shard}.tsv"
        resources:
            mem_mb=1500,
            results_mb=lambda w: scenes_mb(w.split, w.shard, 110),
        params:
            seed=config["seed"],
            scene_seed=lambda w: (
                config["benchmark"]["test_seed"] if w.split == "test" else config["seed"]
            ),
            reference=config["reference"],
            n_looks=config["benchmark"]["n_looks"],
            span=lambda w: shard_range(w.split, w.shard),
            source=SYNTHETIC,
        message:
            "{wildcards.split} scenes, shard {wildcards.shard}, of the synthetic benchmark"
        script:
            "../scripts/reference_scenes.py"

elif SOURCE == "png_pairs":

    # A folder in the published benchmark's layout is the benchmark; the statistics come from its train scenes.
    LISTS = {split: str(Path(PAIRS["folder"]) / PAIRS["lists"][split]) for split in OBSERVED}

    rule check_pairs:
        input:
            lists=list(LISTS.values()),
            images=[pairs.files(slice(None)) for pairs in OBSERVED.values()],
        output:
            table=CHECK,
        log:
            "logs/check_pairs.log",
        benchmark:
            "results/benchmarks/check_pairs/all.tsv"
        params:
            lists=LISTS,
            contrast_db=PAIRS["contrast_db"],
            spacing={
                "bin_size_s": ("import.bin_s", BIN_S),
                "line_spacing_m": ("import.pairs.line_spacing_m", PAIRS["line_spacing_m"]),
            },
        message:
            "check of all scenes"
        script:
            "../scripts/check_pairs.py"

    rule import_pairs:
        input:
            listing=lambda w: LISTS[w.split],
            images=lambda w: OBSERVED[w.split].files(slice(*shard_range(w.split, w.shard))),
            # Not `ancient`: Snakemake does not look for changed settings or files of rules behind a job that has to run,
            # so that scenes imported with the old ones would stay. The same holds for frames.
            check=CHECK,
        output:
            scenes="results/benchmark/{split}/{shard}.nc",
        log:
            "logs/import_pairs/{split}/{shard}.log",
        benchmark:
            "results/benchmarks/import_pairs/{split}/{shard}.tsv"
        params:
            span=lambda w: shard_range(w.split, w.shard),
        message:
            "{wildcards.split} scenes, shard {wildcards.shard}"
        script:
            "../scripts/import_pairs.py"

    rule summarise_scenes:
        input:
            scenes="results/benchmark/train/{shard}.nc",
        output:
            summary="results/statistics/{shard}.nc",
        log:
            "logs/summarise_scenes/{shard}.log",
        benchmark:
            "results/benchmarks/summarise_scenes/{shard}.tsv"
        params:
            bin_s=OWN["bin_s"],
            line_spacing_m=PAIRS["line_spacing_m"],
            contrast_db=PAIRS["contrast_db"],
        message:
            "sums over train scenes, shard {wildcards.shard}"
        script:
            "../scripts/summarise_scenes.py"

else:

    # Own frames are the flight and, cut into blocks, the benchmark.
    READING = {name: OWN[name] for name in ("bin_s", "flattening", "layer_names", "flagged_by")}
    READING["source"] = SOURCE

    rule check_frames:
        input:
            frames=OWN["frames"],
            files=[sources.frame_files(row) for row in sum(OBSERVED.values(), [])],
        output:
            table=CHECK,
        log:
            "logs/check_frames.log",
        benchmark:
            "results/benchmarks/check_frames/all.tsv"
        resources:
            mem_mb=4000,
        params:
            reading=READING,
        message:
            "check of all frames"
        script:
            "../scripts/check_frames.py"

    rule import_frame:
        input:
            unpack(lambda w: sources.frame_inputs(OBSERVED["statistics"][int(w.frame)])),
            check=CHECK,
        output:
            frame="results/flight/{frame}.nc",
            layers="results/flight/{frame}_layers.nc",
        log:
            "logs/import_frame/{frame}.log",
        benchmark:
            "results/benchmarks/import_frame/{frame}.tsv"
        resources:
            mem_mb=4000,
        params:
            name=lambda w: OBSERVED["statistics"][int(w.frame)]["frame"],
            reading=READING,
        message:
            "frame {params.name} of the flight"
        script:
            "../scripts/import_frame.py"

    rule import_blocks:
        input:
            unpack(lambda w: sources.frame_inputs(OBSERVED[w.split][int(w.shard)])),
            check=CHECK,
        output:
            scenes="results/benchmark/{split}/{shard}.nc",
        log:
            "logs/import_blocks/{split}/{shard}.log",
        benchmark:
            "results/benchmarks/import_blocks/{split}/{shard}.tsv"
        resources:
            mem_mb=4000,
        params:
            name=lambda w: OBSERVED[w.split][int(w.shard)]["frame"],
            reading=READING,
        message:
            "{wildcards.split} scenes of frame {params.name}"
        script:
            "../scripts/import_blocks.py"


if FRAME_SHARDS:

    rule summarise_frames:
        input:
            echograms=lambda w: expand("results/flight/{frame}.nc", frame=FRAME_SHARDS[w.shard]),
            layers=lambda w: expand("results/flight/{frame}_layers.nc", frame=FRAME_SHARDS[w.shard]),
        output:
            summary="results/statistics/{shard}.nc",
        log:
            "logs/summarise_frames/{shard}.log",
        benchmark:
            "results/benchmarks/summarise_frames/{shard}.tsv"
        message:
            "sums over frames, shard {wildcards.shard}"
        script:
            "../scripts/summarise_frames.py"


rule flight:
    input:
        CHECK,
        expand("results/flight/{frame}.nc", frame=FRAMES),
        SEGMENT,
        benchmark_files(*SPLITS),
    message:
        "the sample flight and the benchmark"
