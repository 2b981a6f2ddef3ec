# The study of flights: worth of synthetic scenes over flights with climates and radars of their own. Nothing on the way
# from flight to Table III depends on this file, and the default run leaves it out.
#
# Every flight is a whole run of this workflow in its own folder, with another seed, climate and radar. After a change of
# code, remove the flights' folders. Pages show the tables that are kept in workflow/evaluation: put
# results/studies/flights/scores.csv and depths.csv in place of measured_flights.csv and measured_flights_depths.csv.

from evaluation.lib import flights

FLOWN = config["studies"]["flights"]
FLIGHTS = flights.flights_of(FLOWN["first_seed"], FLOWN["n_flights"])
FLOWN_SETS = list(FLOWN["n_gradients"].items())


wildcard_constraints:
    flight=r"\d+",
    study="flights|choices|annotation",


# One flight.


rule score_flight:
    input:
        scores=studied.scored(FLOWN_SETS, "test", "scores"),
        depths=studied.scored(FLOWN_SETS, "test", "depths"),
    output:
        scores="results/one_flight/flights.csv",
        depths="results/one_flight/flights_depths.csv",
    log:
        "logs/score_flight.log",
    benchmark:
        "results/benchmarks/score_flight/all.tsv"
    message:
        "fused edge scores of every training of one flight"
    script:
        "../scripts/join_tables.py"


# All flights. A run goes on where it was stopped. It takes no lock, since its folder belongs to this job alone.


rule fly:
    # Not a script, because it needs Snakemake, which the environment of scripts does not have.
    output:
        scores="results/studies/{study}/{flight}/results/one_flight/{study}.csv",
        depths="results/studies/{study}/{flight}/results/one_flight/{study}_depths.csv",
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
        depths=expand(rules.fly.output.depths, study="flights", flight=FLIGHTS),
    output:
        **drawn("study_flights", "flights_worth.svg", "flights_depths.svg"),
        scores="results/studies/flights/scores.csv",
        worth="results/studies/flights/worth.csv",
        depths="results/studies/flights/depths.csv",
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
        "worth of synthetic scenes on flights of other climates and radars: 2.5 hours on two cores"
