# What the statistics of PHY's renders give back of the statistics that went into them; decides PHY's conventions.


include: "closed_loop_parts.smk"


use rule fit_statistics as fit_other_statistics with:
    output:
        statistics="results/closed_loop/flight_{estimator}.nc",
    log:
        "logs/fit_other_statistics/{estimator}.log",
    benchmark:
        "results/benchmarks/fit_other_statistics/{estimator}.tsv"
    params:
        estimator=lambda wildcards: wildcards.estimator,
    message:
        "flight statistics by the estimator {wildcards.estimator}"


rule render_closed_loop:
    input:
        layers=lambda wildcards: loop_labels(int(wildcards.part)),
        statistics="results/statistics.nc",
        code=imported_by("render_closed_loop.py"),
    output:
        summary=temp("results/closed_loop/parts/{part}.nc"),
    log:
        "logs/render_closed_loop/{part}.log",
    benchmark:
        "results/benchmarks/render_closed_loop/{part}.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        convention=LOOP_DEFAULT,
        seed=config["seed"],
        tolerance_db=config["phy"]["tolerance_db"],
        speckle_correlation=config["phy"]["speckle_correlation"],
        first=lambda wildcards: loop_shards(int(wildcards.part))[1],
        span=lambda wildcards: LOOP_PARTS[int(wildcards.part)],
        stride=LOOP_STRIDE,
    message:
        "sums over renders, part {wildcards.part}"
    script:
        "../scripts/render_closed_loop.py"


rule estimate_closed_loop:
    input:
        summaries=expand(
            "results/closed_loop/parts/{part}.nc", part=range(len(LOOP_PARTS))
        ),
        statistics="results/statistics.nc",
        code=imported_by("estimate_closed_loop.py"),
    output:
        statistics=f"results/closed_loop/{LOOP_DEFAULT}_all.nc",
        table=f"results/closed_loop/{LOOP_DEFAULT}_all.csv",
    log:
        "logs/estimate_closed_loop.log",
    benchmark:
        "results/benchmarks/estimate_closed_loop/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=2000,
    message:
        "statistics of renders of all label sets"
    script:
        "../scripts/estimate_closed_loop.py"


rule try_convention:
    input:
        layers=loop_labels(0),
        statistics=loop_statistics,
        code=imported_by("try_convention.py"),
    output:
        statistics="results/closed_loop/{convention}_first.nc",
        table="results/closed_loop/{convention}_first.csv",
    log:
        "logs/try_convention/{convention}.log",
    benchmark:
        "results/benchmarks/try_convention/{convention}.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        convention=lambda wildcards: wildcards.convention,
        seed=config["seed"],
        tolerance_db=config["phy"]["tolerance_db"],
        speckle_correlation=config["phy"]["speckle_correlation"],
        first=0,
        span=LOOP_PARTS[0],
        stride=LOOP_STRIDE,
    message:
        "statistics of renders by {wildcards.convention}"
    script:
        "../scripts/try_convention.py"


rule tabulate_closed_loop:
    input:
        table=f"results/closed_loop/{LOOP_DEFAULT}_all.csv",
        tables=expand(
            "results/closed_loop/{convention}_first.csv", convention=LOOP_CONVENTIONS
        ),
        statistics=expand(
            "results/closed_loop/{convention}_first.nc", convention=LOOP_CONVENTIONS
        ),
        code=imported_by("tabulate_closed_loop.py"),
    output:
        table="results/tables/closed_loop.csv",
        summary="results/tables/closed_loop_summary.csv",
        conventions="results/tables/closed_loop_conventions.csv",
    log:
        "logs/tabulate_closed_loop.log",
    benchmark:
        "results/benchmarks/tabulate_closed_loop/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        conventions=LOOP_CONVENTIONS,
    message:
        "tables of the closed loop"
    script:
        "../scripts/tabulate_closed_loop.py"


rule plot_closed_loop:
    input:
        table="results/tables/closed_loop.csv",
        conventions="results/tables/closed_loop_conventions.csv",
        code=imported_by("plot_closed_loop.py"),
    output:
        figure=report(
            "results/figures/closed_loop.svg", caption="../report/closed_loop.rst"
        ),
    log:
        "logs/plot_closed_loop.log",
    benchmark:
        "results/benchmarks/plot_closed_loop/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        source=NOTE,
    message:
        "figure of the closed loop"
    script:
        "../scripts/plot_closed_loop.py"


rule closed_loop:
    input:
        rules.tabulate_closed_loop.output,
        rules.plot_closed_loop.output,
    message:
        "statistics that went into PHY beside those its renders give back"
