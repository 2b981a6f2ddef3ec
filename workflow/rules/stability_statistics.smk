# Where the estimators of flight statistics fail, and by which rule they degrade.

# Under half a minute; a flight of test size gets the ends of every sweep alone.
ATLAS_SHARE = 1.0 if config["flight"]["n_frames"] >= 10 else 0.2


rule stress_statistics:
    input:
        code=imported_by("stress_statistics.py"),
    output:
        atlas="results/tables/stability_statistics.csv",
    log:
        "logs/stress_statistics.log",
    benchmark:
        "results/benchmarks/stress_statistics/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        share=ATLAS_SHARE,
        seed=config["seed"],
    message:
        "stability atlas of the estimators"
    script:
        "../scripts/stress_statistics.py"


rule stability_statistics:
    input:
        rules.stress_statistics.output,
        *figure_files("atlas"),
    message:
        "stability atlas of the estimators and its figures"
