# The study of budgets: each training set and control with more and more gradients, scored on validation scenes, beside what
# trainings and scenes cost. The default run leaves it out and draws the table that is kept in workflow/evaluation: after a
# change of code or defaults, put results/studies/budgets.csv in its place. The best number of gradients of each set is
# a setting: tracker.n_gradients and studies.flights.n_gradients.

STUDIED = config["studies"]["budgets"]
BUDGETS = [
    (name, n)
    for name in studied.SETS
    for n in STUDIED["n_gradients"]
    if n <= STUDIED["ends"].get(name, n)
]


rule tabulate_budgets:
    input:
        scores=studied.scored(BUDGETS, "validation", "scores"),
        depths=studied.scored(BUDGETS, "validation", "depths"),
    output:
        budgets="results/studies/budgets.csv",
        depths="results/studies/budgets_depths.csv",
    log:
        "logs/tabulate_budgets.log",
    benchmark:
        "results/benchmarks/tabulate_budgets/all.tsv"
    params:
        benchmarks="results/benchmarks",
        # Rules that make the scenes of a training set beside RD.
        made_by={
            "phy": ["render_phy/labels"],
            "cgan": ["train_cgan", "render_cgan/labels"],
            "cgan_as_picked": ["train_cgan_as_picked", "render_cgan_as_picked"],
        },
    message:
        "cost of trainings and scenes, and their worth on validation scenes"
    script:
        "../scripts/tabulate_budgets.py"


rule study_budgets:
    input:
        rules.tabulate_budgets.output,
    message:
        "worth of every training set by number of gradients: 3 hours on two cores"
