# Studies of many trainings each: nothing on the way from flight to Table III depends on this file. Not part of the
# default run: snakemake studies.

from lib import tracker_runs

# What makes synthetic data help or hurt the tracker. Settings are compared, and chosen, on the held-out validation
# scenes. Training sets whose worth is asked for are scored on the test scenes, whatever the others say of them.
STUDY, TRACKER = config["studies"]["tracker"], config["tracker"]
ABLATION_SEEDS = list(range(STUDY["n_ablation_seeds"]))
WORTH_SEEDS = list(range(STUDY["n_seeds"]))
ABLATION = tracker_runs.ablation_of(STUDY, TRAINING_SETS)
ABLATION_RUNS = [
    (setting, training_set)
    for setting, changes in ABLATION.items()
    for training_set in changes["training_sets"]
]
NETWORKS = tracker_runs.networks_of(STUDY)
STUDIED = {**ABLATION, **NETWORKS}
or_refused(tracker_runs.check_names, STUDY)
WORTH = tracker_runs.worth_of(STUDY)
WORTH_RUNS = list(dict.fromkeys(run for pair in WORTH for run in pair))


wildcard_constraints:
    setting="|".join(setting for setting in STUDIED if setting != "default"),
    any_setting="|".join(STUDIED),


use rule render_phy as render_study_phy with:
    input:
        layers="results/labels/{shard}.nc",
        statistics=lambda w: STATISTICS[
            tracker_runs.estimator_of(STUDIED[w.setting], config)
        ],
        code=imported_by("render_phy.py"),
    output:
        scenes="results/studies/tracker/{setting}/phy/{shard}.nc",
    log:
        "logs/render_study_phy/{setting}/{shard}.log",
    benchmark:
        "results/benchmarks/render_study_phy/{setting}/{shard}.tsv"
    params:
        phy=lambda w: tracker_runs.phy_of(STUDIED[w.setting], config["phy"]),
    message:
        "PHY renders of {wildcards.setting}, shard {wildcards.shard}"


use rule train_tracker as train_study_tracker with:
    input:
        real=real_scenes,
        phy=lambda w: tracker_runs.renders_of(
            w.setting, STUDIED[w.setting], added_scenes("phy")(w)
        ),
        cgan=added_scenes("cgan"),
        code=imported_by("train_tracker.py"),
    output:
        network="results/studies/tracker/{setting}/{training_set}/{replica}.safetensors",
        losses="results/studies/tracker/{setting}/{training_set}/{replica}_losses.csv",
    log:
        "logs/train_study_tracker/{setting}/{training_set}/{replica}.log",
    benchmark:
        "results/benchmarks/train_study_tracker/{setting}/{training_set}/{replica}.tsv"
    params:
        n_epochs=lambda w: tracker_runs.epochs_of(STUDIED[w.setting], TRACKER),
        data=lambda w: tracker_runs.data_of(STUDIED[w.setting], TRACKER),
        settings=lambda w: tracker_runs.training_of(STUDIED[w.setting], TRACKER),
        skip=lambda w: STUDIED[w.setting].get("skip", 0),
        checkpoint="results/checkpoints/train_study_tracker_{setting}_{training_set}_{replica}.safetensors",
        events=None,
    message:
        "tracker on {wildcards.training_set}, {wildcards.setting}, replica {wildcards.replica}"


use rule score_tracker as score_study_tracker with:
    input:
        scenes=lambda wildcards: benchmark_files(wildcards.split),
        networks=lambda w: [
            tracker_runs.network_file(w.any_setting, w.training_set, w.replica)
        ],
        code=imported_by("score_tracker.py"),
    output:
        counts=[
            "results/studies/tracker/{any_setting}/{training_set}/{replica}_{split}.parquet"
        ],
    log:
        "logs/score_study_tracker/{any_setting}/{training_set}/{replica}_{split}.log",
    benchmark:
        "results/benchmarks/score_study_tracker/{any_setting}/{training_set}/{replica}_{split}.tsv"
    params:
        outputs=["fuse"],
    message:
        "fused edge scores of {wildcards.training_set}, {wildcards.any_setting}, replica {wildcards.replica}"


rule tabulate_ablation:
    input:
        counts=tracker_runs.count_files("validation", ABLATION_RUNS, ABLATION_SEEDS),
        code=imported_by("tabulate_ablation.py"),
    output:
        table="results/studies/tracker/ablation.csv",
    log:
        "logs/tabulate_ablation.log",
    benchmark:
        "results/benchmarks/tabulate_ablation/all.tsv"
    params:
        seed=config["seed"],
        n_bootstrap=TRACKER["n_bootstrap"],
        runs=ABLATION_RUNS,
        pairs=tracker_runs.pairs_of(ABLATION_RUNS),
        replicas=ABLATION_SEEDS,
    message:
        "ablation of the training sets, on the validation scenes"
    script:
        "../scripts/tabulate_ablation.py"


use rule tabulate_ablation as tabulate_worth with:
    input:
        counts=tracker_runs.count_files("test", WORTH_RUNS, WORTH_SEEDS),
        code=imported_by("tabulate_ablation.py"),
    output:
        table="results/studies/tracker/worth.csv",
    log:
        "logs/tabulate_worth.log",
    benchmark:
        "results/benchmarks/tabulate_worth/all.tsv"
    params:
        runs=WORTH_RUNS,
        pairs=WORTH,
        replicas=WORTH_SEEDS,
    message:
        "what training sets are worth, on the test scenes"


rule time_trackers:
    input:
        scenes=benchmark_files("validation"),
        networks=[
            tracker_runs.network_file(name, "rd", 0) for name in ["default", *NETWORKS]
        ],
        counts=[
            f"results/studies/tracker/{name}/rd/0_validation.parquet"
            for name in ["default", *NETWORKS]
        ],
        code=imported_by("time_trackers.py"),
    output:
        table="results/tables/speed_accuracy_tracker.csv",
    log:
        "logs/time_trackers.log",
    benchmark:
        "results/benchmarks/time_trackers/all.tsv"
    resources:
        mem_mb=2000,
    params:
        names=["default", *NETWORKS],
        n_scenes=5,
        n_rounds=5,
    message:
        "seconds per image of trackers of other width"
    script:
        "../scripts/time_trackers.py"


rule atlas_tracker:
    input:
        train=benchmark_files("train"),
        scenes=benchmark_files("validation"),
        network="results/tracker/rd/0.safetensors",
        statistics="results/statistics.nc",
        code=imported_by("atlas_tracker.py"),
    output:
        table="results/studies/tracker/atlas.csv",
    log:
        "logs/atlas_tracker.log",
    benchmark:
        "results/benchmarks/atlas_tracker/all.tsv"
    resources:
        mem_mb=2000,
    params:
        seed=config["seed"],
        settings=TRACKER["training"],
        phy=config["phy"],
        atlas=STUDY["atlas"],
    message:
        "where the tracker fails"
    script:
        "../scripts/atlas_tracker.py"


rule study_tracker:
    input:
        "results/studies/tracker/ablation.csv",
        rules.tabulate_worth.output,
        rules.time_trackers.output,
        rules.atlas_tracker.output,
        figure_files("study_tracker"),
    localrule: True
    message:
        "what makes synthetic data help or hurt the tracker, its cost and where it fails"


# The conditional GAN: spread over seeds, speed against similarity, atlas. Trainings of the default are those of
# train_cgan itself.

CGAN_STUDY = config["studies"]["cgan"]
CGAN_SEEDS = [config["seed"] + number for number in range(1, CGAN_STUDY["n_seeds"])]
CGAN_RUNS = [
    (mode, width)
    for mode in ("equal_steps", "equal_time")
    for width in CGAN_STUDY["widths"]
]


wildcard_constraints:
    cgan_seed=r"\d+",
    cgan_width=r"\d+",
    cgan_mode="equal_steps|equal_time",


use rule train_cgan as study_cgan_seed with:
    output:
        generator="results/studies/cgan/seed_{cgan_seed}/generator.safetensors",
        losses="results/studies/cgan/seed_{cgan_seed}/losses.csv",
        scores="results/studies/cgan/seed_{cgan_seed}/validation.csv",
        samples="results/studies/cgan/seed_{cgan_seed}/samples.nc",
    log:
        "logs/study_cgan_seed/{cgan_seed}.log",
    benchmark:
        "results/benchmarks/study_cgan_seed/{cgan_seed}.tsv"
    params:
        seed=lambda wildcards: int(wildcards.cgan_seed),
        checkpoint="results/checkpoints/study_cgan_seed/{cgan_seed}.safetensors",
        events="logs/tensorboard/study_cgan_seed/{cgan_seed}",
    message:
        "cGAN training with seed {wildcards.cgan_seed}"


rule study_cgan_score:
    input:
        observed=benchmark_files("test"),
        default="results/similarity.parquet",
        generators=[
            f"results/studies/cgan/seed_{seed}/generator.safetensors"
            for seed in CGAN_SEEDS
        ],
        code=imported_by("study_cgan_score.py"),
    output:
        images=[
            f"results/studies/cgan/seed_{seed}/similarity.parquet"
            for seed in CGAN_SEEDS
        ],
        table="results/studies/cgan/seeds.csv",
    log:
        "logs/study_cgan_score.log",
    benchmark:
        "results/benchmarks/study_cgan_score/all.tsv"
    resources:
        mem_mb=2000,
        gpu=int(config["cgan"]["device"] == "cuda"),
    params:
        seed=config["seed"],
        seeds=[config["seed"], *CGAN_SEEDS],
        device=config["cgan"]["device"],
        statistics=config["cgan"]["statistics"],
    message:
        "spread of Table II over seeds"
    script:
        "../scripts/study_cgan_score.py"


rule study_cgan_speed:
    input:
        train=benchmark_files("train"),
        statistics="results/statistics.nc",
        code=imported_by("study_cgan_speed.py"),
    output:
        table="results/studies/cgan/speed.csv",
    log:
        "logs/study_cgan_speed.log",
    benchmark:
        "results/benchmarks/study_cgan_speed/all.tsv"
    resources:
        mem_mb=2000,
    params:
        seed=config["seed"],
        settings=config["cgan"]["training"],
        widths=CGAN_STUDY["widths"],
        n_rounds=CGAN_STUDY["n_rounds"],
        phy=config["phy"],
    message:
        "seconds per step and per render by width"
    script:
        "../scripts/study_cgan_speed.py"


rule study_cgan_width:
    input:
        train=benchmark_files("train"),
        speed="results/studies/cgan/speed.csv",
        code=imported_by("study_cgan_width.py"),
    output:
        generator="results/studies/cgan/{cgan_mode}_{cgan_width}/generator.safetensors",
        losses="results/studies/cgan/{cgan_mode}_{cgan_width}/losses.csv",
        scores="results/studies/cgan/{cgan_mode}_{cgan_width}/validation.csv",
        samples="results/studies/cgan/{cgan_mode}_{cgan_width}/samples.nc",
    log:
        "logs/study_cgan_width/{cgan_mode}_{cgan_width}.log",
    benchmark:
        "results/benchmarks/study_cgan_width/{cgan_mode}_{cgan_width}.tsv"
    resources:
        mem_mb=4000,
    params:
        mode="{cgan_mode}",
        width=lambda wildcards: int(wildcards.cgan_width),
        n_steps=CGAN_STUDY["n_steps"],
        seconds=CGAN_STUDY["seconds"],
        training={**dict(rules.train_cgan.params.items()), "on_collapse": "go_on"},
        checkpoint="results/checkpoints/study_cgan_width/{cgan_mode}_{cgan_width}.safetensors",
        events="logs/tensorboard/study_cgan_width/{cgan_mode}_{cgan_width}",
    message:
        "cGAN training of width {wildcards.cgan_width}, {wildcards.cgan_mode}"
    script:
        "../scripts/study_cgan_width.py"


rule study_cgan_tabulate_widths:
    input:
        speed="results/studies/cgan/speed.csv",
        bounds="results/tables/similarity_bounds.csv",
        validations=[
            f"results/studies/cgan/{mode}_{width}/validation.csv"
            for mode, width in CGAN_RUNS
        ],
        code=imported_by("study_cgan_tabulate_widths.py"),
    output:
        table="results/studies/cgan/widths.csv",
    log:
        "logs/study_cgan_tabulate_widths.log",
    benchmark:
        "results/benchmarks/study_cgan_tabulate_widths/all.tsv"
    params:
        runs=CGAN_RUNS,
    message:
        "speed and similarity of the cGAN by width"
    script:
        "../scripts/study_cgan_tabulate_widths.py"


rule study_cgan_atlas:
    input:
        train=benchmark_files("train"),
        code=imported_by("study_cgan_atlas.py"),
    output:
        table="results/studies/cgan/atlas.csv",
    log:
        "logs/study_cgan_atlas.log",
    benchmark:
        "results/benchmarks/study_cgan_atlas/all.tsv"
    resources:
        mem_mb=2000,
    params:
        seed=config["seed"],
        settings={**config["cgan"]["training"], **CGAN_STUDY["atlas"]["training"]},
        statistics=config["cgan"]["statistics"],
        n_held=config["cgan"]["validation"]["n_scenes"],
        n_seeds=CGAN_STUDY["atlas"]["n_seeds"],
        learning_rates=CGAN_STUDY["atlas"]["learning_rates"],
        l1_weights=CGAN_STUDY["atlas"]["l1_weights"],
    message:
        "atlas of the cGAN: seeds, rates, L1 weights"
    script:
        "../scripts/study_cgan_atlas.py"


rule study_cgan:
    input:
        rules.study_cgan_score.output.table,
        rules.study_cgan_tabulate_widths.output,
        rules.study_cgan_atlas.output,
        figure_files("study_cgan"),
    localrule: True
    message:
        "studies of the cGAN"


# Waveforms of the nadir altimetry solver of SMRT beside eq. (1) and the nature run: needs the package smrt.


rule study_convolution_smrt:
    input:
        code=imported_by("study_convolution_smrt.py"),
    output:
        table="results/studies/convolution/smrt.csv",
        curves="results/studies/convolution/smrt_waveforms.csv",
    log:
        "logs/study_convolution_smrt.log",
    benchmark:
        "results/benchmarks/study_convolution_smrt/all.tsv"
    params:
        reference=config["reference"],
    message:
        "waveforms of SMRT, of the nature run, and the best fits of eq. (1)"
    script:
        "../scripts/study_convolution_smrt.py"


rule study_convolution:
    input:
        rules.study_convolution_smrt.output,
    localrule: True
    message:
        "SMRT beside the convolution model; the figure of the target convolution takes it in when that is run next"
