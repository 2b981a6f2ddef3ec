# The study of flights: worth of synthetic scenes over flights with climates and radars of their own. Nothing on the way
# from flight to Table III depends on this file, and the default run leaves it out.
#
# Every flight is a whole run of this workflow in its own folder, with another seed, climate and radar. After a change of
# code, remove the flights' folders.

from evaluation.lib import flights

FLOWN = config["studies"]["flights"]
FLIGHTS = flights.flights_of(FLOWN["first_seed"], FLOWN["n_flights"])
# RD with every layer labelled, and with the sample flight's annotated blocks in place of synthetic scenes.
CONTROLS = ["rd_full", "rd_own"]
SCORED_SETS = [*TRAINING_SETS, *ALONE, *CONTROLS]


wildcard_constraints:
    flight=r"\d+",
    study="flights|choices",
    control="|".join(CONTROLS),


# One flight: the main path and, beside it, trainings on the controls.


rule cut_flight:
    input:
        echograms=expand("results/flight/{frame}.nc", frame=FRAMES),
        layers=expand("results/flight/{frame}_layers.nc", frame=FRAMES),
    output:
        scenes="results/one_flight/own.nc",
    log:
        "logs/cut_flight.log",
    benchmark:
        "results/benchmarks/cut_flight/all.tsv"
    params:
        source=SYNTHETIC,
    message:
        "annotated blocks of the sample flight as scenes"
    script:
        "../scripts/cut_flight.py"


use rule train_tracker as train_control with:
    input:
        real=lambda w: (
            benchmark_files("train") + (rules.cut_flight.output if w.control == "rd_own" else [])
        ),
    output:
        network="results/tracker/{control}/{replica}.safetensors",
        losses="results/tracker/{control}/{replica}_losses.csv",
    log:
        "logs/train_control/{control}/{replica}.log",
    benchmark:
        "results/benchmarks/train_control/{control}/{replica}.tsv"
    params:
        data=lambda w: rules.train_tracker.params.data
        | ({"labels": "complete"} if w.control == "rd_full" else {}),
        checkpoint=f"{CHECKPOINTS}/train_control_{{control}}_{{replica}}.safetensors",
        events=f"{EVENTS}/train_control/{{control}}/{{replica}}",
    message:
        "tracker on {wildcards.control}, replica {wildcards.replica}"


rule score_flight:
    input:
        counts=expand(
            "results/tracker/{training_set}/{replica}_counts.parquet",
            training_set=SCORED_SETS,
            replica=SEEDS,
        ),
    output:
        scores="results/one_flight/flights.csv",
    log:
        "logs/score_flight.log",
    benchmark:
        "results/benchmarks/score_flight/all.tsv"
    params:
        trainings=[(name, replica) for name in SCORED_SETS for replica in SEEDS],
    message:
        "fused edge scores of every training of one flight"
    script:
        "../scripts/score_flight.py"


# All flights. A run goes on where it was stopped. It takes no lock, since its folder belongs to this job alone.


rule fly:
    # Not a script, because it needs Snakemake, which the environment of scripts does not have.
    output:
        scores="results/studies/{study}/{flight}/results/one_flight/{study}.csv",
    log:
        "logs/fly/{study}/{flight}.log",
    benchmark:
        "results/benchmarks/fly/{study}/{flight}.tsv"
    threads: 4
    resources:
        mem_mb=12000,
        runtime=1440,
        results_mb=1500,
    params:
        folder="results/studies/{study}/{flight}",
        settings=lambda w: flights.flight_config(config, w.study, w.flight),
    message:
        "a whole run for flight {wildcards.flight}, study of {wildcards.study}"
    run:
        settings_file = Path(params.folder, "config.yaml")
        settings_file.write_text(yaml.safe_dump(params.settings, sort_keys=False))
        shell(
            "{sys.executable} -m snakemake --snakefile {ROOT}/Snakefile --directory {params.folder}"
            " --profile none --workflow-profile {ROOT}/profiles/default"
            " --configfile {settings_file} --cores {threads} --nolock"
            " -- results/one_flight/{wildcards.study}.csv > {log} 2>&1"
        )


rule tabulate_flights:
    input:
        scores=expand(rules.fly.output.scores, study="flights", flight=FLIGHTS),
    output:
        **drawn("study_flights", "flights_worth.svg"),
        worth="results/studies/flights/worth.csv",
    log:
        "logs/tabulate_flights.log",
    benchmark:
        "results/benchmarks/tabulate_flights/all.tsv"
    params:
        flights=FLIGHTS,
        source=NOTE,
    message:
        "worth of training sets over flights: table and figure"
    script:
        "../scripts/tabulate_flights.py"


rule study_flights:
    input:
        rules.tabulate_flights.output,
    message:
        "worth of synthetic scenes on flights of other climates and radars: 1 hour on two cores"
