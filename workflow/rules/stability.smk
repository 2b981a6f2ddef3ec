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


rule stability:
    input:
        rules.stress_phy.output,
        *figure_files("atlas"),
        "results/tables/stability_statistics.csv",
    message:
        "stability atlases of PHY and of the estimators, with their figures"
