# Where PHY's methods fail, and that its public functions do not.


rule stress_phy:
    input:
        code=imported_by("stress_phy.py"),
    output:
        atlas="results/tables/stability_phy.csv",
        regions="results/tables/stability_phy_regions.csv",
    log:
        "logs/stress_phy.log",
    benchmark:
        "results/benchmarks/stress_phy/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        seed=config["seed"],
    message:
        "stability atlas of PHY"
    script:
        "../scripts/stress_phy.py"


rule plot_phy_stability:
    input:
        atlas="results/tables/stability_phy.csv",
        code=imported_by("plot_phy_stability.py"),
    output:
        figure=report(
            "results/figures/stability_phy.svg", caption="../report/stability_phy.rst"
        ),
    log:
        "logs/plot_phy_stability.log",
    benchmark:
        "results/benchmarks/plot_phy_stability/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    message:
        "figure of the stability atlas"
    script:
        "../scripts/plot_phy_stability.py"


rule stability:
    input:
        rules.stress_phy.output,
        rules.plot_phy_stability.output,
        "results/tables/stability_statistics.csv",
        "results/figures/stability_statistics.svg",
        "results/figures/stability_statistics_borders.svg",
    message:
        "stability atlases of PHY and of the estimators, with their figures"
