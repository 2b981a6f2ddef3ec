# The sample flight, sums over its frames, and the benchmark (train, validation and test scenes).


if SOURCE == "reference":

    # A rule for each shard: a job of one frame takes longer to start than to draw it, and no wildcard names many outputs.
    for shard, frames in FRAME_SHARDS.items():

        rule:
            name:
                f"reference_frames_{shard}"
            input:
                code=imported_by("reference_frames.py"),
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
                results_mb=math.ceil(
                    len(frames) * config["flight"]["n_range_lines"] * 3.7e-3
                ),
            params:
                frames=[int(frame) for frame in frames],
                seed=config["seed"],
                flight={
                    "n_frames": config["flight"]["n_frames"],
                    "n_range_lines": config["flight"]["n_range_lines"],
                },
                reference=config["reference"],
            message:
                f"frames of the synthetic reference flight, shard {shard}"
            script:
                "../scripts/reference_frames.py"

    rule reference_scenes:
        input:
            code=imported_by("reference_scenes.py"),
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
            reference=config["reference"],
            n_looks=config["benchmark"]["n_looks"],
            split="{split}",
            span=lambda wildcards: shard_range(wildcards.split, wildcards.shard),
            source=SYNTHETIC,
        message:
            "{wildcards.split} scenes, shard {wildcards.shard}, of the synthetic benchmark"
        script:
            "../scripts/reference_scenes.py"

elif SOURCE == "png_pairs":

    # A folder in the published benchmark's layout is the benchmark; the statistics come from its train scenes.
    LISTS = {
        split: str(Path(PAIRS["folder"]) / PAIRS["lists"][split]) for split in OBSERVED
    }

    rule check_pairs:
        input:
            unread=[
                list(LISTS.values()),
                [pairs.files(slice(None)) for pairs in OBSERVED.values()],
            ],
            code=imported_by("check_pairs.py"),
        output:
            table=CHECK,
        log:
            "logs/check_pairs.log",
        benchmark:
            "results/benchmarks/check_pairs/all.tsv"
        params:
            lists=LISTS,
            data_scale=PAIRS["data_scale"],
            contrast_db=PAIRS["contrast_db"],
        message:
            "check of all scenes"
        script:
            "../scripts/check_pairs.py"

    rule import_pairs:
        input:
            listing=lambda wildcards: LISTS[wildcards.split],
            # Not `ancient`: while the check has to run, Snakemake asks no rule behind it whether its own settings or
            # files have changed, and what was imported with the old ones would stay. The same holds for frames.
            unread=lambda w: [
                CHECK,
                *OBSERVED[w.split].files(slice(*shard_range(w.split, w.shard))),
            ],
            code=imported_by("import_pairs.py"),
        output:
            scenes="results/benchmark/{split}/{shard}.nc",
        log:
            "logs/import_pairs/{split}/{shard}.log",
        benchmark:
            "results/benchmarks/import_pairs/{split}/{shard}.tsv"
        params:
            split="{split}",
            span=lambda wildcards: shard_range(wildcards.split, wildcards.shard),
            data_scale=PAIRS["data_scale"],
        message:
            "{wildcards.split} scenes, shard {wildcards.shard}"
        script:
            "../scripts/import_pairs.py"

    rule summarise_scenes:
        input:
            scenes="results/benchmark/train/{shard}.nc",
            code=imported_by("summarise_scenes.py"),
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
    READING = {
        "source": SOURCE,
        "bin_s": OWN["bin_s"],
        "flattening": OWN["flattening"],
        "layer_names": OWN["layer_names"],
        "flagged_by": OWN["flagged_by"],
    }
    FILES = [
        sources.frame_files(row, SOURCE) for rows in OBSERVED.values() for row in rows
    ]

    rule check_frames:
        input:
            frames=OWN["frames"],
            unread=sorted(set(sum(FILES, []))),
            code=imported_by("check_frames.py"),
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
            **frame_inputs(lambda w: OBSERVED["statistics"][int(w.frame)]),
            code=imported_by("import_frame.py"),
        output:
            frame="results/flight/{frame}.nc",
            frame_layers="results/flight/{frame}_layers.nc",
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
            **frame_inputs(lambda w: OBSERVED[w.split][int(w.shard)]),
            code=imported_by("import_blocks.py"),
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
            echograms=lambda wildcards: expand(
                "results/flight/{frame}.nc", frame=FRAME_SHARDS[wildcards.shard]
            ),
            layers=lambda wildcards: expand(
                "results/flight/{frame}_layers.nc", frame=FRAME_SHARDS[wildcards.shard]
            ),
            code=imported_by("summarise_frames.py"),
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
