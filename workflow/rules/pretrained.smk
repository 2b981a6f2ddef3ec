# The tracker that comes with the package, and the study of how it does on flights it never saw. Not part of the default
# run: snakemake pretrained, snakemake transfer.

from lib import transfer

PRETRAINED, TRANSFER = config["pretrained"], config["studies"]["transfer"]
# All networks that are compared are alike.
LARGER = TRACKER["training"] | PRETRAINED["training"]
VARIANTS_PER_SHARD = 72
VARIED_SHARDS = numbered(math.ceil(PRETRAINED["n_variants"] / VARIANTS_PER_SHARD))
TUNING = {flight["name"]: flight for flight in PRETRAINED["tuning"]}
UNSEEN = {flight["name"]: flight for flight in TRANSFER["flights"]}
OTHER_FLIGHTS = TUNING | UNSEEN
# Jobs start without what this imports.
if workflow.is_main_process:
    or_refused(
        transfer.check_flights, PRETRAINED["tuning"], TRANSFER["flights"], config
    )
# Of range bins, as scenes are brought to the default's.
TUNING_SHARES = [
    transfer.scale_of(flight, config["reference"]["radar"])[0]
    for flight in TUNING.values()
]
# Parts of another flight: its split of the benchmark, and the scenes of that.
PARTS = transfer.parts_of(TRANSFER["n_scenes"])
# Of the default flight.
COMPARED = ["rd", "pd", "rd_pd"]
SCORES_OF_UNSEEN = "results/tables/transfer.csv"


wildcard_constraints:
    other_flight="|".join(OTHER_FLIGHTS),
    part="|".join(PARTS),


rule draw_varied:
    input:
        statistics="results/statistics.nc",
        code=imported_by("draw_varied.py"),
    output:
        scenes="results/pretrained/scenes/{shard}.nc",
    log:
        "logs/draw_varied/{shard}.log",
    benchmark:
        "results/benchmarks/draw_varied/{shard}.tsv"
    resources:
        results_mb=math.ceil(VARIANTS_PER_SHARD * PRETRAINED["n_scenes"] * 0.22),
    params:
        seed=config["seed"],
        variants=lambda w: transfer.variants_of(
            int(w.shard), VARIANTS_PER_SHARD, PRETRAINED["n_variants"]
        ),
        n_scenes=PRETRAINED["n_scenes"],
        n_range_lines=config["labels"]["n_range_lines"],
        phy=config["phy"],
    message:
        "scenes of other climates and radars, shard {wildcards.shard}"
    script:
        "../scripts/draw_varied.py"


use rule train_tracker as train_pretrained with:
    input:
        real=expand("results/pretrained/scenes/{shard}.nc", shard=VARIED_SHARDS),
        phy=[],
        cgan=[],
        code=imported_by("train_tracker.py"),
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
        settings=LARGER,
        checkpoint=f"{CHECKPOINTS}/train_pretrained.safetensors",
        events=f"{EVENTS}/train_pretrained",
    message:
        "the tracker that comes with the package"


rule other_flight_scenes:
    input:
        code=imported_by("reference_scenes.py"),
    output:
        scenes="results/other_flights/{other_flight}/{part}.nc",
    log:
        "logs/other_flight_scenes/{other_flight}/{part}.log",
    benchmark:
        "results/benchmarks/other_flight_scenes/{other_flight}/{part}.tsv"
    resources:
        mem_mb=1500,
    params:
        seed=lambda w: OTHER_FLIGHTS[w.other_flight]["seed"],
        reference=lambda w: transfer.reference_of(
            OTHER_FLIGHTS[w.other_flight], config["reference"]
        ),
        n_looks=lambda w: OTHER_FLIGHTS[w.other_flight].get(
            "n_looks", config["benchmark"]["n_looks"]
        ),
        split=lambda w: PARTS[w.part].split,
        span=lambda w: PARTS[w.part].span,
        source="synthetic reference flight, not observed data",
    message:
        "{wildcards.part} scenes of the flight {wildcards.other_flight}"
    script:
        "../scripts/reference_scenes.py"


rule calibrate_pretrained:
    input:
        network="results/pretrained/network.safetensors",
        scenes=expand("results/other_flights/{flight}/test.nc", flight=TUNING),
        code=imported_by("calibrate_tracker.py"),
    output:
        calibration="results/pretrained/calibration.csv",
        reliability="results/pretrained/reliability.csv",
    log:
        "logs/calibrate_pretrained.log",
    benchmark:
        "results/benchmarks/calibrate_pretrained/all.tsv"
    params:
        bin_shares=TUNING_SHARES,
    message:
        "calibration of the tracker that comes with the package"
    script:
        "../scripts/calibrate_tracker.py"


rule calibrate_picks:
    input:
        network="results/pretrained/network.safetensors",
        calibration="results/pretrained/calibration.csv",
        scenes=expand("results/other_flights/{flight}/test.nc", flight=TUNING),
        code=imported_by("calibrate_picks.py"),
    output:
        confidence="results/pretrained/confidence.csv",
        reliability="results/pretrained/pick_reliability.csv",
    log:
        "logs/calibrate_picks.log",
    benchmark:
        "results/benchmarks/calibrate_picks/all.tsv"
    params:
        bin_shares=TUNING_SHARES,
    message:
        "how sure picks of the tracker are that comes with the package"
    script:
        "../scripts/calibrate_picks.py"


rule ship_tracker:
    input:
        network="results/pretrained/network.safetensors",
        calibration="results/pretrained/calibration.csv",
        confidence="results/pretrained/confidence.csv",
        statistics="results/statistics.nc",
        code=imported_by("ship_tracker.py"),
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
        radar={
            "bin_s": config["reference"]["radar"]["bin_size_s"],
            "line_spacing_m": config["reference"]["radar"]["line_spacing_m"],
            "n_looks": config["benchmark"]["n_looks"],
        },
        scores=finished([SCORES_OF_UNSEEN]),
    message:
        "the tracker in the form in which it comes with the package"
    script:
        "../scripts/ship_tracker.py"


rule pretrained:
    input:
        rules.ship_tracker.output,
        rules.calibrate_pretrained.output.reliability,
        rules.calibrate_picks.output.reliability,
    message:
        "the tracker that comes with the package, with its card: about 20 min of one core"


# Flights that nothing was trained or tuned on. The same network on scenes of the default flight, and as a control on
# fully annotated scenes of each flight: each for as long as the longest of the control's trainings.
AS_LONG_AS_CONTROL = LARGER | {"n_steps": max(TRANSFER["n_steps"])}


use rule train_tracker as train_compared with:
    output:
        network="results/transfer/{training_set}/network.safetensors",
        losses="results/transfer/{training_set}/losses.csv",
    log:
        "logs/train_compared/{training_set}.log",
    benchmark:
        "results/benchmarks/train_compared/{training_set}.tsv"
    params:
        replica="compared",
        n_epochs=None,
        settings=AS_LONG_AS_CONTROL,
        checkpoint=f"{CHECKPOINTS}/train_compared_{{training_set}}.safetensors",
        events=None,
    message:
        "larger tracker on {wildcards.training_set}"


use rule calibrate_pretrained as calibrate_compared with:
    input:
        network="results/transfer/{training_set}/network.safetensors",
        scenes=benchmark_files("validation"),
        code=imported_by("calibrate_tracker.py"),
    output:
        calibration="results/transfer/{training_set}/calibration.csv",
        reliability="results/transfer/{training_set}/reliability.csv",
    log:
        "logs/calibrate_compared/{training_set}.log",
    benchmark:
        "results/benchmarks/calibrate_compared/{training_set}.tsv"
    params:
        bin_shares=[1 for _ in benchmark_files("validation")],
    message:
        "calibration of the larger tracker on {wildcards.training_set}"


rule train_control:
    input:
        scenes="results/other_flights/{other_flight}/own.nc",
        held="results/other_flights/{other_flight}/held.nc",
        code=imported_by("train_control.py"),
    output:
        network="results/transfer/control/{other_flight}/network.safetensors",
        calibration="results/transfer/control/{other_flight}/calibration.csv",
        choice="results/transfer/control/{other_flight}/choice.csv",
    log:
        "logs/train_control/{other_flight}.log",
    benchmark:
        "results/benchmarks/train_control/{other_flight}.tsv"
    resources:
        mem_mb=2000,
    params:
        seed=lambda w: OTHER_FLIGHTS[w.other_flight]["seed"],
        settings=LARGER,
        n_steps=TRANSFER["n_steps"],
        checkpoint="results/checkpoints/train_control_{other_flight}",
        checkpoint_steps=config["checkpoints"]["every_steps"],
    message:
        "tracker on annotated scenes of {wildcards.other_flight} itself"
    script:
        "../scripts/train_control.py"


rule score_transfer:
    input:
        scenes="results/other_flights/{other_flight}/test.nc",
        networks=[
            "results/pretrained/network.safetensors",
            *expand("results/transfer/{name}/network.safetensors", name=COMPARED),
            "results/transfer/control/{other_flight}/network.safetensors",
        ],
        calibrations=[
            "results/pretrained/calibration.csv",
            *expand("results/transfer/{name}/calibration.csv", name=COMPARED),
            "results/transfer/control/{other_flight}/calibration.csv",
        ],
        confidence="results/pretrained/confidence.csv",
        code=imported_by("score_transfer.py"),
    output:
        scores="results/transfer/scores/{other_flight}.csv",
        reliability="results/transfer/scores/{other_flight}_reliability.csv",
    log:
        "logs/score_transfer/{other_flight}.log",
    benchmark:
        "results/benchmarks/score_transfer/{other_flight}.tsv"
    resources:
        mem_mb=2000,
    params:
        names=["universal", *COMPARED, "control"],
        flight="{other_flight}",
        scale=lambda w: transfer.scale_of(
            OTHER_FLIGHTS[w.other_flight], config["reference"]["radar"]
        ),
    message:
        "all trackers on the flight {wildcards.other_flight}"
    script:
        "../scripts/score_transfer.py"


rule tabulate_transfer:
    input:
        scores=expand("results/transfer/scores/{flight}.csv", flight=UNSEEN),
        reliability=expand(
            "results/transfer/scores/{flight}_reliability.csv", flight=UNSEEN
        ),
        code=imported_by("tabulate_transfer.py"),
    output:
        table=SCORES_OF_UNSEEN,
        curves="results/tables/transfer_reliability.csv",
    log:
        "logs/tabulate_transfer.log",
    benchmark:
        "results/benchmarks/tabulate_transfer/all.tsv"
    message:
        "scores on flights never seen"
    script:
        "../scripts/tabulate_transfer.py"


rule transfer:
    input:
        rules.tabulate_transfer.output,
    message:
        "the tracker that comes with the package on flights it never saw: hours of one core"
