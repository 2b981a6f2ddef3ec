# What synthetic scenes are worth over flights of their own climates and radars, and how many annotated scenes they save.
# Nothing on the way from flight to Table III depends on this file; not part of the default run.
#
# Every flight is a whole run of this workflow in a folder of its own, with a configuration of its own. The first part
# holds what such a run makes beyond the main path; the second starts the runs and puts their scores together.

import sys

from evaluation.lib import flights

FLIGHTS_STUDY = config["studies"]["flights"]
FLIGHTS = flights.flights_of(FLIGHTS_STUDY)
FEW = flights.few_of(FLIGHTS_STUDY)
FLIGHT_RUNS = [*flights.MAIN, *flights.CONTROLS, *FEW]
FLIGHT_REPLICAS = list(range(FLIGHTS_STUDY["n_trainings"]))
# As rule draw_labels has them.
LABEL_SETTINGS = {
    name: value
    for name, value in rules.draw_labels.params.items()
    if name not in ("seed", "span")
}
OWN_BLOCKS = expand("results/one_flight/blocks/{shard}.nc", shard=FRAME_SHARDS)
or_refused(flights.check_curve, FLIGHTS_STUDY, N_SCENES["train"])


wildcard_constraints:
    flight=r"\d+",
    n_few=r"\d+",
    control="|".join(flights.CONTROLS),
    generator=r"[1-9]\d*",
    by_generator="|".join(flights.WITH_CGAN),
    few="|".join(FEW) or "none",
    flight_run="|".join(FLIGHT_RUNS),


# One flight: the annotated blocks that its statistics come from, as scenes to train on.


rule cut_flight:
    input:
        echograms=lambda w: expand(
            "results/flight/{frame}.nc", frame=FRAME_SHARDS[w.shard]
        ),
        layers=lambda w: expand(
            "results/flight/{frame}_layers.nc", frame=FRAME_SHARDS[w.shard]
        ),
        code=imported_by(EVALUATION / "cut_flight.py"),
    output:
        scenes="results/one_flight/blocks/{shard}.nc",
    log:
        "logs/cut_flight/{shard}.log",
    benchmark:
        "results/benchmarks/cut_flight/{shard}.tsv"
    message:
        "annotated blocks of the sample flight, shard {wildcards.shard}"
    script:
        "../scripts/cut_flight.py"


use rule train_tracker as train_flight_control with:
    input:
        real=lambda w: benchmark_files("train")
        + (OWN_BLOCKS if flights.CONTROLS[w.control].with_own else []),
        phy=lambda w: (
            rendered_files("phy", "labels")
            if flights.CONTROLS[w.control].with_phy
            else []
        ),
        cgan=[],
        code=imported_by("train_tracker.py"),
    output:
        network="results/one_flight/{control}/{replica}.safetensors",
        losses="results/one_flight/{control}/{replica}_losses.csv",
    log:
        "logs/train_flight_control/{control}/{replica}.log",
    benchmark:
        "results/benchmarks/train_flight_control/{control}/{replica}.tsv"
    params:
        data=lambda w: {
            "added_per_real": config["tracker"]["added_per_real"],
            "order": config["tracker"]["order"],
            "labels": flights.CONTROLS[w.control].labels,
        },
        checkpoint=f"{CHECKPOINTS}/train_flight_control_{{control}}_{{replica}}.safetensors",
        events=None,
    message:
        "tracker on {wildcards.control}, replica {wildcards.replica}"


# Trainings on scenes of the cGAN have a generator each, so that its scatter is theirs. The first is the main path's.


use rule train_cgan as train_flight_cgan with:
    output:
        generator="results/one_flight/cgan/{generator}/generator.safetensors",
        losses="results/one_flight/cgan/{generator}/losses.csv",
        scores="results/one_flight/cgan/{generator}/validation.csv",
        samples="results/one_flight/cgan/{generator}/samples.nc",
    log:
        "logs/train_flight_cgan/{generator}.log",
    benchmark:
        "results/benchmarks/train_flight_cgan/{generator}.tsv"
    params:
        seed=lambda w: flights.generator_seed(config["seed"], w.generator),
        checkpoint=f"{CHECKPOINTS}/train_flight_cgan_{{generator}}.safetensors",
        events=None,
    message:
        "cGAN training, generator {wildcards.generator}"


use rule render_cgan as render_flight_cgan with:
    input:
        layers="results/labels/{shard}.nc",
        generator="results/one_flight/cgan/{generator}/generator.safetensors",
        statistics="results/statistics.nc",
        code=imported_by("render_cgan.py"),
    output:
        scenes="results/one_flight/cgan/{generator}/labels/{shard}.nc",
    log:
        "logs/render_flight_cgan/{generator}/{shard}.log",
    benchmark:
        "results/benchmarks/render_flight_cgan/{generator}/{shard}.tsv"
    resources:
        mem_mb=3000,
        gpu=int(config["cgan"]["device"] == "cuda"),
        results_mb=lambda wildcards: scenes_mb("labels", wildcards.shard, 220),
    message:
        "cGAN renders by generator {wildcards.generator}, shard {wildcards.shard}"


use rule train_tracker as train_by_generator with:
    input:
        real=lambda w: (
            benchmark_files("train") if w.by_generator in TRAINING_SETS else []
        ),
        phy=lambda w: (
            rendered_files("phy", "labels")
            if "phy" in (TRAINING_SETS | ALONE)[w.by_generator]
            else []
        ),
        cgan=lambda w: expand(
            "results/one_flight/cgan/{generator}/labels/{shard}.nc",
            generator=w.generator,
            shard=shards("labels"),
        ),
        code=imported_by("train_tracker.py"),
    output:
        network="results/one_flight/{by_generator}/{generator}.safetensors",
        losses="results/one_flight/{by_generator}/{generator}_losses.csv",
    log:
        "logs/train_by_generator/{by_generator}/{generator}.log",
    benchmark:
        "results/benchmarks/train_by_generator/{by_generator}/{generator}.tsv"
    params:
        replica="{generator}",
        checkpoint=f"{CHECKPOINTS}/train_by_generator_{{by_generator}}_{{generator}}.safetensors",
        events=None,
    message:
        "tracker on {wildcards.by_generator}, generator and replica {wildcards.generator}"


# Its learning curve: from a few annotated scenes and their picks come statistics, label sets, and trackers.


rule take_few:
    input:
        scenes=benchmark_files("train"),
        code=imported_by(EVALUATION / "take_few.py"),
    output:
        few="results/one_flight/few/{n_few}/scenes.nc",
    log:
        "logs/take_few/{n_few}.log",
    benchmark:
        "results/benchmarks/take_few/{n_few}.tsv"
    params:
        n_scenes=lambda wildcards: int(wildcards.n_few),
    message:
        "the first {wildcards.n_few} train scenes"
    script:
        "../scripts/take_few.py"


# Few scenes may hold too little for statistics, or for label sets: what is trained beyond this is known when it is made.
checkpoint fit_few:
    input:
        few="results/one_flight/few/{n_few}/scenes.nc",
        code=imported_by(EVALUATION / "fit_few.py"),
    output:
        statistics="results/one_flight/few/{n_few}/statistics.nc",
        choice="results/one_flight/few/{n_few}/choice.csv",
    log:
        "logs/fit_few/{n_few}.log",
    benchmark:
        "results/benchmarks/fit_few/{n_few}.tsv"
    params:
        seed=config["seed"],
        estimator=config["statistics"]["estimator"],
        finest_lines=config["statistics"]["finest_lines"],
        bin_s=config["reference"]["radar"]["bin_size_s"],
        line_spacing_m=config["reference"]["radar"]["line_spacing_m"],
        contrast_db=None,
        synthetic=SYNTHETIC,
        labels=LABEL_SETTINGS,
    message:
        "statistics of {wildcards.n_few} train scenes"
    script:
        "../scripts/fit_few.py"


rule draw_few:
    input:
        statistics="results/one_flight/few/{n_few}/statistics.nc",
        choice="results/one_flight/few/{n_few}/choice.csv",
        code=imported_by(EVALUATION / "draw_few.py"),
    output:
        labels="results/one_flight/few/{n_few}/labels/{shard}.nc",
    log:
        "logs/draw_few/{n_few}/{shard}.log",
    benchmark:
        "results/benchmarks/draw_few/{n_few}/{shard}.tsv"
    resources:
        results_mb=lambda wildcards: scenes_mb("labels", wildcards.shard, 18),
    params:
        seed=config["seed"],
        span=lambda wildcards: shard_range("labels", wildcards.shard),
        settings=LABEL_SETTINGS,
    message:
        "label sets after {wildcards.n_few} train scenes, shard {wildcards.shard}"
    script:
        "../scripts/draw_few.py"


use rule render_phy as render_few with:
    input:
        layers="results/one_flight/few/{n_few}/labels/{shard}.nc",
        statistics="results/one_flight/few/{n_few}/statistics.nc",
        code=imported_by("render_phy.py"),
    output:
        scenes="results/one_flight/few/{n_few}/phy/{shard}.nc",
    log:
        "logs/render_few/{n_few}/{shard}.log",
    benchmark:
        "results/benchmarks/render_few/{n_few}/{shard}.tsv"
    resources:
        results_mb=lambda wildcards: scenes_mb("labels", wildcards.shard, 220),
    message:
        "PHY renders after {wildcards.n_few} train scenes, shard {wildcards.shard}"


use rule train_tracker as train_few with:
    input:
        real=lambda w: FEW[w.few].real_files(),
        phy=lambda w: FEW[w.few].drawn_files(shards("labels")),
        cgan=[],
        code=imported_by("train_tracker.py"),
    output:
        network="results/one_flight/{few}/{replica}.safetensors",
        losses="results/one_flight/{few}/{replica}_losses.csv",
    log:
        "logs/train_few/{few}/{replica}.log",
    benchmark:
        "results/benchmarks/train_few/{few}/{replica}.tsv"
    params:
        checkpoint=f"{CHECKPOINTS}/train_few_{{few}}_{{replica}}.safetensors",
        events=None,
    message:
        "tracker on {wildcards.few} scenes, replica {wildcards.replica}"


# Its scores.


use rule score_tracker as score_flight_run with:
    input:
        scenes=benchmark_files("test"),
        networks=lambda w: flights.network_files(w.flight_run, FLIGHT_REPLICAS),
        code=imported_by("score_tracker.py"),
    output:
        counts=expand(
            "results/one_flight/{{flight_run}}/{replica}_counts.parquet",
            replica=FLIGHT_REPLICAS,
        ),
    log:
        "logs/score_flight_run/{flight_run}.log",
    benchmark:
        "results/benchmarks/score_flight_run/{flight_run}.tsv"
    params:
        outputs=["fuse"],
    message:
        "fused edge scores of {wildcards.flight_run}, every replica"


rule score_universal:
    input:
        scenes=benchmark_files("test"),
        weights=str(ROOT / "snowsim/data/universal.onnx"),
        code=imported_by(EVALUATION / "score_universal.py"),
    output:
        counts="results/one_flight/universal/0_counts.parquet",
    log:
        "logs/score_universal.log",
    benchmark:
        "results/benchmarks/score_universal/all.tsv"
    message:
        "fused edge scores of the tracker that comes with the package"
    script:
        "../scripts/score_universal.py"


rule collect_flight:
    input:
        counts=flights.count_files(
            flights.whole_runs(FLIGHTS_STUDY),
        ),
        few_counts=lambda wildcards: flights.count_files(
            flights.few_runs(
                [
                    checkpoints.fit_few.get(n_few=n).output.choice
                    for n in FLIGHTS_STUDY["curve"]
                ],
                FLIGHTS_STUDY,
            )
        ),
        choices=expand(
            "results/one_flight/few/{n}/choice.csv", n=FLIGHTS_STUDY["curve"]
        ),
        code=imported_by(EVALUATION / "collect_flight.py"),
    output:
        table="results/one_flight/counts.parquet",
        few="results/one_flight/few.csv",
    log:
        "logs/collect_flight.log",
    benchmark:
        "results/benchmarks/collect_flight/all.tsv"
    params:
        runs=lambda wildcards, input: [
            *flights.whole_runs(FLIGHTS_STUDY),
            *flights.few_runs(input.choices, FLIGHTS_STUDY),
        ],
    message:
        "edge counts of all trainings of this flight"
    script:
        "../scripts/collect_flight.py"


# All flights.


rule set_flight:
    input:
        code=imported_by(EVALUATION / "set_flight.py"),
    output:
        settings_file="results/studies/flights/{flight}/config.yaml",
    log:
        "logs/set_flight/{flight}.log",
    benchmark:
        "results/benchmarks/set_flight/{flight}.tsv"
    params:
        settings=lambda wildcards: flights.flight_config(config, wildcards.flight),
    message:
        "climate, radar and seed of flight {wildcards.flight}"
    script:
        "../scripts/set_flight.py"


# A whole run, which goes on where it was stopped. Its folder belongs to this job alone: a lock in it is that of a job
# that was killed. Code is named so that it is asked anew; which of its jobs that concerns is for the run to say.
rule fly:
    # Not by a script: it needs Snakemake itself, which the environment of scripts is without.
    input:
        settings="results/studies/flights/{flight}/config.yaml",
        code=sorted(
            path
            for folder in ("snowsim", "workflow")
            for path in (ROOT / folder).rglob("*.py")
        ),
    output:
        counts="results/studies/flights/{flight}/results/one_flight/counts.parquet",
        few="results/studies/flights/{flight}/results/one_flight/few.csv",
    log:
        "logs/fly/{flight}.log",
    benchmark:
        "results/benchmarks/fly/{flight}.tsv"
    threads: 4
    resources:
        mem_mb=12000,
        runtime=1440,
        results_mb=1500,
    params:
        snakemake=f"{sys.executable} -m snakemake",
        snakefile=ROOT / "Snakefile",
        profile=ROOT / "profiles/default",
        folder=lambda wildcards: f"results/studies/flights/{wildcards.flight}",
        target="results/one_flight/counts.parquet",
    message:
        "a whole run for flight {wildcards.flight}"
    run:
        shell(
            "{params.snakemake} --snakefile {params.snakefile} --directory {params.folder}"
            " --profile none --workflow-profile {params.profile} --configfile {input.settings}"
            " --cores {threads} --nolock -- {params.target} > {log} 2>&1"
        )


rule tabulate_flights:
    input:
        counts=expand(
            "results/studies/flights/{flight}/results/one_flight/counts.parquet",
            flight=FLIGHTS,
        ),
        few=expand(
            "results/studies/flights/{flight}/results/one_flight/few.csv",
            flight=FLIGHTS,
        ),
        code=imported_by(EVALUATION / "tabulate_flights.py"),
    output:
        scores="results/studies/flights/scores.csv",
        worth="results/studies/flights/worth.csv",
        curve="results/studies/flights/curve.csv",
        drawn="results/studies/flights/flights.csv",
    log:
        "logs/tabulate_flights.log",
    benchmark:
        "results/benchmarks/tabulate_flights/all.tsv"
    resources:
        mem_mb=3000,
    params:
        seed=config["seed"],
        n_bootstrap=config["tracker"]["n_bootstrap"],
        flights=FLIGHTS,
        reference=config["reference"],
        numbers=FLIGHTS_STUDY["curve"],
    message:
        "worth of training sets over flights, and the learning curve"
    script:
        "../scripts/tabulate_flights.py"


rule plot_study_flights:
    input:
        worth="results/studies/flights/worth.csv",
        scores="results/studies/flights/scores.csv",
        curve="results/studies/flights/curve.csv",
        code=imported_by(EVALUATION / "plot_study_flights.py"),
    output:
        **drawn("study_flights", "flights_worth.svg", "learning_curve.svg"),
    log:
        "logs/plot_study_flights.log",
    benchmark:
        "results/benchmarks/plot_study_flights/all.tsv"
    params:
        source=NOTE,
    message:
        "figures of the study of flights"
    script:
        "../scripts/plot_study_flights.py"


rule study_flights:
    input:
        rules.tabulate_flights.output,
        rules.plot_study_flights.output,
    message:
        "worth of synthetic scenes on flights of other climates and radars, and the annotated scenes they save"
