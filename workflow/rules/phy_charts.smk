# Speed of PHY against its accuracy, and what its plans leave out.

PLANTED = {"n_layers": 15, "n_range_lines": 256, "n_range_bins": 256}


rule measure_phy_waveforms:
    input:
        code=imported_by("measure_phy_waveforms.py"),
    output:
        table="results/tables/speed_accuracy_waveforms.csv",
    log:
        "logs/measure_phy_waveforms.log",
    benchmark:
        "results/benchmarks/measure_phy_waveforms/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        **PLANTED,
        n_rounds=9,
        seed=config["seed"],
    message:
        "speed and accuracy of mean power"
    script:
        "../scripts/measure_phy_waveforms.py"


rule measure_phy_speckle:
    input:
        code=imported_by("measure_phy_speckle.py"),
    output:
        table="results/tables/speed_accuracy_speckle.csv",
    log:
        "logs/measure_phy_speckle.log",
    benchmark:
        "results/benchmarks/measure_phy_speckle/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        n_range_lines=PLANTED["n_range_lines"],
        n_range_bins=PLANTED["n_range_bins"],
        n_rounds=9,
        seed=config["seed"],
    message:
        "speed and accuracy of speckle"
    script:
        "../scripts/measure_phy_speckle.py"


rule measure_scenes:
    input:
        code=imported_by("measure_scenes.py"),
    output:
        scenes="results/tables/speed_accuracy_scenes.csv",
        growth="results/tables/speed_accuracy_growth.csv",
    log:
        "logs/measure_scenes.log",
    benchmark:
        "results/benchmarks/measure_scenes/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=2000,
    params:
        **PLANTED,
        n_rounds=9,
        seed=config["seed"],
        reference=config["reference"],
        n_looks=config["benchmark"]["n_looks"],
        cgan={
            key: config["cgan"]["training"][key]
            for key in ("width", "depth", "precision")
        },
    message:
        "speed and accuracy of whole scenes"
    script:
        "../scripts/measure_scenes.py"


rule summarise_phy_plan:
    input:
        scenes=rendered_files("phy", "labels"),
        code=imported_by("summarise_phy_plan.py"),
    output:
        plans="results/phy_plans.parquet",
        table="results/tables/phy_plan.csv",
    log:
        "logs/summarise_phy_plan.log",
    benchmark:
        "results/benchmarks/summarise_phy_plan/all.tsv"
    conda:
        "../../envs/cpu.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    message:
        "what the plans of all label scenes left out"
    script:
        "../scripts/summarise_phy_plan.py"


rule charts_phy:
    input:
        rules.measure_phy_waveforms.output,
        rules.measure_phy_speckle.output,
        rules.measure_scenes.output,
        rules.summarise_phy_plan.output,
        *figure_files("phy"),
        rules.stability.input,
    message:
        "speed-accuracy charts and stability atlas of PHY"
