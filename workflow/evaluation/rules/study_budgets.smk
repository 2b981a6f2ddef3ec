# The study of budgets: ODS on validation scenes of trackers on RD and on PD by number of gradients, and of those on GD and on
# RD+PD, beside what trainings and scenes cost. The default run leaves it out and draws the table that is kept in
# workflow/evaluation: after a change of code or defaults, put results/studies/budgets.csv in its place.

STUDIED = config["studies"]["budgets"]
BUDGETS = [(name, n) for name in ("rd", "pd") for n in STUDIED["n_gradients"]]
BUDGETS += [(name, TRACKER["training"]["n_steps"]) for name in ("gd", "rd_pd")]
BUDGET_RUNS = [
    (*budget, replica) for budget in BUDGETS for replica in range(STUDIED["n_trainings"])
]


wildcard_constraints:
    n_gradients=r"\d+",


use rule train_tracker as train_budget with:
    output:
        network="results/studies/budgets/{training_set}/{n_gradients}/{replica}.safetensors",
        losses="results/studies/budgets/{training_set}/{n_gradients}/{replica}_losses.csv",
    log:
        "logs/train_budget/{training_set}/{n_gradients}/{replica}.log",
    benchmark:
        "results/benchmarks/train_budget/{training_set}/{n_gradients}/{replica}.tsv"
    params:
        n_epochs=None,
        settings=lambda w: TRACKER["training"] | {"n_steps": int(w.n_gradients)},
        checkpoint="results/checkpoints/budget_{training_set}_{n_gradients}_{replica}.safetensors",
        events="logs/tensorboard/train_budget/{training_set}/{n_gradients}/{replica}",
    message:
        "tracker on {wildcards.training_set}, {wildcards.n_gradients} gradients, replica {wildcards.replica}"


rule tabulate_budgets:
    input:
        networks=[
            f"results/studies/budgets/{name}/{n}/{replica}.safetensors"
            for name, n, replica in BUDGET_RUNS
        ],
        scenes=benchmark_files("validation"),
    output:
        budgets="results/studies/budgets.csv",
    log:
        "logs/tabulate_budgets.log",
    benchmark:
        "results/benchmarks/tabulate_budgets/all.tsv"
    resources:
        mem_mb=2000,
    params:
        runs=BUDGET_RUNS,
        benchmarks="results/benchmarks",
        # Rules that make the scenes of a training set, beside RD.
        made_by={
            "rd": [],
            "pd": ["render_phy/labels"],
            "rd_pd": ["render_phy/labels"],
            "gd": ["train_cgan", "render_cgan/labels"],
        },
    message:
        "cost of trainings and scenes, and their worth on validation scenes"
    script:
        "../scripts/tabulate_budgets.py"


rule study_budgets:
    input:
        rules.tabulate_budgets.output,
    message:
        "worth of trackers by number of gradients: 10 minutes on two cores"
