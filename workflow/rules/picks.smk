# Layers of own echograms without annotation: every frame of the table of frames with the role track, for any `source`.


if workflow.is_main_process:
    or_refused(sources.check_tracker, OWN["tracker"])


rule track_frames:
    input:
        echograms=lambda w: [row["echogram"] for row in frames_of_job(w.shard)],
        # Supplements, and the files of Zarr stores.
        others=lambda w: [
            file
            for row in frames_of_job(w.shard)
            for file in sources.echogram_files(row["echogram"])[1:]
        ],
        tracker=sources.own_tracker(OWN["tracker"]),
    output:
        folder=directory("results/picks/{shard}"),
    log:
        "logs/track_frames/{shard}.log",
    benchmark:
        "results/benchmarks/track_frames/{shard}.tsv"
    resources:
        # Measured: up to 550 MB for 10 frames of 1,000 lines (23 MB of files), 1,030 for a segment of 50 (115 MB).
        mem_mb=lambda wildcards, input, attempt: attempt * (700 + math.ceil(8 * input.size_mb)),
    params:
        frames=lambda w: [row["frame"] for row in frames_of_job(w.shard)],
        model=OWN["tracker"],
        shipped=of_checkout(*sources.shipped_tracker(OWN["tracker"])),
    message:
        "layers of own frames, job {wildcards.shard}"
    script:
        "../scripts/track_frames.py"


rule tabulate_picks:
    input:
        folders=lambda w: expand("results/picks/{shard}", shard=frames_by_job()),
    output:
        table="results/tables/tracked_frames.csv",
    log:
        "logs/tabulate_picks.log",
    benchmark:
        "results/benchmarks/tabulate_picks/all.tsv"
    message:
        "what was picked in which frame"
    script:
        "../scripts/tabulate_picks.py"


rule picks:
    input:
        rules.tabulate_picks.output,
    message:
        "layers of own echograms without annotation: frames of import.frames with the role track"
