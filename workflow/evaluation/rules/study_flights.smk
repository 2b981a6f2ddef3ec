# The study of flights: worth of synthetic scenes over flights with climates and radars of their own. Nothing on the way
# from flight to Table III depends on this file, and the default run leaves it out.
#
# Every flight is a whole run of this workflow in its own folder, with another seed, climate and radar. After a change of
# code, remove the flights' folders.

from evaluation.lib import flights

FLOWN = config["studies"]["flights"]
FLIGHTS = flights.flights_of(FLOWN["first_seed"], FLOWN["n_flights"])
SCORED_SETS = [*TRAINING_SETS, *ALONE, "rd_full"]


wildcard_constraints:
    flight=r"\d+",


# One flight: the main path and, beside it, trainings on RD with every layer labelled.


use rule train_tracker as train_rd_full with:
    input:
        real=benchmark_files("train"),
        phy=[],
        cgan=[],
    output:
        network="results/tracker/rd_full/{replica}.safetensors",
        losses="results/tracker/rd_full/{replica}_losses.csv",
    log:
        "logs/train_rd_full/{replica}.log",
    benchmark:
        "results/benchmarks/train_rd_full/{replica}.tsv"
    params:
        data=rules.train_tracker.params.data | {"labels": "complete"},
        checkpoint=f"{CHECKPOINTS}/train_rd_full_{{replica}}.safetensors",
        events=f"{EVENTS}/train_rd_full/{{replica}}",
    message:
        "tracker on RD with every layer labelled, replica {wildcards.replica}"


use rule score_tracker as score_rd_full with:
    input:
        scenes=benchmark_files("test"),
        validation=benchmark_files("validation"),
        networks=expand(rules.train_rd_full.output.network, replica=SEEDS),
    output:
        counts=expand("results/tracker/rd_full/{replica}_counts.parquet", replica=SEEDS),
        picks=expand("results/tracker/rd_full/{replica}_picks.parquet", replica=SEEDS),
        validation=validation_counts("results/tracker/rd_full/{replica}"),
    log:
        "logs/score_rd_full.log",
    benchmark:
        "results/benchmarks/score_rd_full/all.tsv"
    message:
        "edge scores of RD with every layer labelled"


rule score_flight:
    input:
        counts=expand(
            "results/tracker/{training_set}/{replica}_counts.parquet",
            training_set=SCORED_SETS,
            replica=SEEDS,
        ),
    output:
        scores="results/one_flight/scores.csv",
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
        scores="results/studies/flights/{flight}/results/one_flight/scores.csv",
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
        folder="results/studies/flights/{flight}",
        settings=lambda wildcards: flights.flight_config(config, wildcards.flight),
    message:
        "a whole run for flight {wildcards.flight}"
    run:
        settings_file = Path(params.folder, "config.yaml")
        settings_file.write_text(yaml.safe_dump(params.settings, sort_keys=False))
        shell(
            "{sys.executable} -m snakemake --snakefile {ROOT}/Snakefile --directory {params.folder}"
            " --profile none --workflow-profile {ROOT}/profiles/default"
            " --configfile {settings_file} --cores {threads} --nolock"
            " -- results/one_flight/scores.csv > {log} 2>&1"
        )


rule tabulate_flights:
    input:
        scores=expand(rules.fly.output.scores, flight=FLIGHTS),
    output:
        worth="results/studies/flights/worth.csv",
    log:
        "logs/tabulate_flights.log",
    benchmark:
        "results/benchmarks/tabulate_flights/all.tsv"
    params:
        flights=FLIGHTS,
    message:
        "worth of training sets over flights"
    script:
        "../scripts/tabulate_flights.py"


rule plot_study_flights:
    input:
        worth="results/studies/flights/worth.csv",
    output:
        **drawn("study_flights", "flights_worth.svg"),
    log:
        "logs/plot_study_flights.log",
    benchmark:
        "results/benchmarks/plot_study_flights/all.tsv"
    params:
        source=NOTE,
    message:
        "figure of the study of flights"
    script:
        "../scripts/plot_study_flights.py"


rule study_flights:
    input:
        rules.tabulate_flights.output,
        rules.plot_study_flights.output,
    message:
        "worth of synthetic scenes on flights of other climates and radars: hours"
