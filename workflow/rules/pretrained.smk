# The tracker that comes with the package, and its scores on flights it never saw. Not part of the default run:
# snakemake pretrained, snakemake transfer.

from pretrained import transfer

PRETRAINED = config["pretrained"]
TRANSFER = config["studies"]["transfer"]
# Variants are divided into files as scenes are.
N_SCENES["variants"] = PRETRAINED["n_variants"]
SHARD_SIZE["variants"] = 72
TUNING = {flight["name"]: flight for flight in PRETRAINED["tuning"]}
UNSEEN = {flight["name"]: flight for flight in TRANSFER["flights"]}
OTHER_FLIGHTS = TUNING | UNSEEN
# Only the main process checks: jobs are spared the imports of the check.
if workflow.is_main_process:
    or_refused(transfer.check_flights, PRETRAINED["tuning"], TRANSFER["flights"], config)
# Factors that resample range bins and range lines of another flight to the default's.
SCALES = {
    name: transfer.scale_of(flight, config["reference"]) for name, flight in OTHER_FLIGHTS.items()
}


wildcard_constraints:
    other_flight="|".join(OTHER_FLIGHTS),


rule draw_varied:
    input:
        statistics="results/statistics.nc",
    output:
        scenes="results/pretrained/scenes/{shard}.nc",
    log:
        "logs/draw_varied/{shard}.log",
    benchmark:
        "results/benchmarks/draw_varied/{shard}.tsv"
    resources:
        results_mb=math.ceil(SHARD_SIZE["variants"] * PRETRAINED["n_scenes"] * 0.22),
    params:
        seed=config["seed"],
        variants=lambda w: shard_range("variants", w.shard),
        n_varied=transfer.n_varied(PRETRAINED),
        n_scenes=PRETRAINED["n_scenes"],
        n_range_lines=config["labels"]["n_range_lines"],
        phy=config["phy"],
    message:
        "scenes of other climates and radars and of clean firn, shard {wildcards.shard}"
    script:
        "../scripts/draw_varied.py"


use rule train_tracker as train_pretrained with:
    input:
        real=expand("results/pretrained/scenes/{shard}.nc", shard=shards("variants")),
    output:
        network="results/pretrained/network.safetensors",
        losses="results/pretrained/losses.csv",
    log:
        "logs/train_pretrained.log",
    benchmark:
        "results/benchmarks/train_pretrained/all.tsv"
    params:
        replica="pretrained",
        n_epochs=None,
        data={"added_per_real": 0},
        settings=TRACKER["training"] | PRETRAINED["training"],
        checkpoint=f"{CHECKPOINTS}/train_pretrained.safetensors",
        events=f"{EVENTS}/train_pretrained",
    message:
        "the tracker that comes with the package"


rule other_flight_scenes:
    output:
        scenes="results/other_flights/{other_flight}/{split}.nc",
    log:
        "logs/other_flight_scenes/{other_flight}/{split}.log",
    benchmark:
        "results/benchmarks/other_flight_scenes/{other_flight}/{split}.tsv"
    resources:
        mem_mb=1500,
    params:
        seed=lambda w: OTHER_FLIGHTS[w.other_flight]["seed"],
        scene_seed=lambda w: OTHER_FLIGHTS[w.other_flight]["seed"],
        reference=lambda w: transfer.reference_of(
            OTHER_FLIGHTS[w.other_flight], config["reference"]
        ),
        n_looks=lambda w: OTHER_FLIGHTS[w.other_flight].get(
            "n_looks", config["benchmark"]["n_looks"]
        ),
        split="{split}",
        span=(0, TRANSFER["n_scenes"]),
        source="synthetic reference flight, not observed data",
    message:
        "{wildcards.split} scenes of the flight {wildcards.other_flight}"
    script:
        "../scripts/reference_scenes.py"


rule calibrate_pretrained:
    input:
        network="results/pretrained/network.safetensors",
        scenes=expand("results/other_flights/{flight}/test.nc", flight=TUNING),
    output:
        calibration="results/pretrained/calibration.csv",
        reliability="results/pretrained/reliability.csv",
        curve="results/pretrained/pick_curve.csv",
        confidence="results/pretrained/confidence.csv",
        pick_reliability="results/pretrained/pick_reliability.csv",
    log:
        "logs/calibrate_pretrained.log",
    benchmark:
        "results/benchmarks/calibrate_pretrained/all.tsv"
    params:
        bin_shares=[SCALES[flight][0] for flight in TUNING],
    message:
        "calibration of the tracker that comes with the package, and how sure its picks are"
    script:
        "../scripts/calibrate_tracker.py"


rule ship_tracker:
    input:
        network="results/pretrained/network.safetensors",
        calibration="results/pretrained/calibration.csv",
        confidence="results/pretrained/confidence.csv",
        statistics="results/statistics.nc",
    output:
        tracker="results/shipped/universal.onnx",
        card="results/shipped/universal.json",
    log:
        "logs/ship_tracker.log",
    benchmark:
        "results/benchmarks/ship_tracker/all.tsv"
    params:
        n_scenes=PRETRAINED["n_scenes"],
        n_variants=PRETRAINED["n_variants"],
        n_varied=transfer.n_varied(PRETRAINED),
        seed=config["seed"],
        benchmark="results/benchmarks/train_pretrained/all.tsv",
        radar={
            "bin_s": config["reference"]["radar"]["bin_size_s"],
            "line_spacing_m": config["reference"]["radar"]["line_spacing_m"],
            "n_looks": config["benchmark"]["n_looks"],
        },
        scores=finished(["results/tables/transfer.csv"]),
    message:
        "the tracker in the form in which it comes with the package"
    script:
        "../scripts/ship_tracker.py"


rule pretrained:
    input:
        rules.ship_tracker.output,
        rules.calibrate_pretrained.output,
    message:
        "the tracker that comes with the package, with its card: about 1 h of one core"


use rule train_tracker as train_own with:
    input:
        real=["results/other_flights/{other_flight}/train.nc"],
    output:
        network="results/other_flights/{other_flight}/own.safetensors",
        losses="results/other_flights/{other_flight}/own_losses.csv",
    log:
        "logs/train_own/{other_flight}.log",
    benchmark:
        "results/benchmarks/train_own/{other_flight}.tsv"
    params:
        replica="own",
        n_epochs=None,
        data={"added_per_real": 0},
        settings=SETTINGS["rd"],
        checkpoint=f"{CHECKPOINTS}/train_own_{{other_flight}}.safetensors",
        events=f"{EVENTS}/train_own/{{other_flight}}",
    message:
        "tracker on annotated scenes of the flight {wildcards.other_flight}"


rule score_transfer:
    input:
        network="results/pretrained/network.safetensors",
        calibration="results/pretrained/calibration.csv",
        confidence="results/pretrained/confidence.csv",
        scenes=expand("results/other_flights/{flight}/test.nc", flight=UNSEEN),
        own=expand("results/other_flights/{flight}/own.safetensors", flight=UNSEEN),
    output:
        table="results/tables/transfer.csv",
        accumulation="results/tables/transfer_accumulation.csv",
    log:
        "logs/score_transfer.log",
    benchmark:
        "results/benchmarks/score_transfer/all.tsv"
    resources:
        mem_mb=2000,
    params:
        flights=list(UNSEEN),
        scales=SCALES,
        seed=config["seed"],
        bin_s={
            name: transfer.reference_of(flight, config["reference"])["radar"]["bin_size_s"]
            for name, flight in UNSEEN.items()
        },
    message:
        "scores on flights that nothing was trained or tuned on"
    script:
        "../scripts/score_transfer.py"


rule transfer:
    input:
        rules.score_transfer.output,
    message:
        "the tracker that comes with the package on flights it never saw: pretrained and minutes more"
