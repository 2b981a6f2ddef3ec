# Speed against accuracy of the task and of PHY, and where PHY and the estimators of statistics fail.


rule measure_phy:
    output:
        table="results/tables/speed_accuracy.csv",
    log:
        "logs/measure_phy.log",
    benchmark:
        "results/benchmarks/measure_phy/all.tsv"
    resources:
        mem_mb=2000,
    params:
        seed=config["seed"],
        cgan=config["cgan"]["training"],
        # The fastest of them is drawn; a run of test size shows that it can be.
        n_rounds=5 if LABELS["n_scenes"] >= 100 else 1,
    message:
        "speed and accuracy of PHY's parts and of whole scenes"
    script:
        "../scripts/measure_phy.py"


rule draw_atlases:
    output:
        phy="results/tables/atlas_phy.csv",
        statistics="results/tables/atlas_statistics.csv",
    log:
        "logs/draw_atlases.log",
    benchmark:
        "results/benchmarks/draw_atlases/all.tsv"
    resources:
        mem_mb=1500,
    params:
        seed=config["seed"],
    message:
        "atlases of PHY and of the estimators"
    script:
        "../scripts/draw_atlases.py"


rule plot_charts:
    input:
        speed_accuracy="results/tables/speed_accuracy.csv",
        atlas_phy="results/tables/atlas_phy.csv",
        atlas_statistics="results/tables/atlas_statistics.csv",
    output:
        **drawn("charts", "speed_accuracy.svg", "atlas.svg"),
    log:
        "logs/plot_charts.log",
    benchmark:
        "results/benchmarks/plot_charts/all.tsv"
    params:
        # What `snakemake study_budgets` left.
        budgets=of_checkout("workflow/evaluation/measured_budgets.csv"),
    message:
        "figures of speed, accuracy and failure"
    script:
        "../scripts/plot_charts.py"
