# Studies of many trainings each, not part of the default run: snakemake studies.

from evaluation.lib import tracker_runs

# What makes synthetic data help or hurt the tracker. Settings are compared, and chosen, on the held-out validation
# scenes. Training sets whose worth is asked for are scored on the test scenes, whatever the others say of them.
STUDY = config["studies"]["tracker"]
ABLATION_SEEDS = list(range(STUDY["n_ablation_seeds"]))
WORTH_SEEDS = list(range(STUDY["n_seeds"]))
ABLATION = tracker_runs.ablation_of(STUDY)
ABLATION_RUNS = [
    (setting, training_set)
    for setting, changes in ABLATION.items()
    for training_set in changes["training_sets"]
]
or_refused(tracker_runs.check_names, STUDY)
WORTH = tracker_runs.worth_of(STUDY)
WORTH_RUNS = list(dict.fromkeys(run for pair in WORTH for run in pair))


wildcard_constraints:
    setting="|".join(setting for setting in ABLATION if setting != "default"),
    any_setting="|".join(ABLATION),


use rule draw_labels as draw_study_labels with:
    output:
        labels="results/studies/tracker/{setting}/labels/{shard}.nc",
    log:
        "logs/draw_study_labels/{setting}/{shard}.log",
    benchmark:
        "results/benchmarks/draw_study_labels/{setting}/{shard}.tsv"
    params:
        n_layers=drawn_by("n_layers"),
        first_slab=drawn_by("first_slab"),
        surface=drawn_by("surface"),
        correlation=drawn_by("correlation"),
        radiometry=drawn_by("radiometry"),
        choices=lambda w: tracker_runs.choices_of(
            ABLATION[w.setting], CHOICES, config["phy"]
        ),
    message:
        "label sets of {wildcards.setting}, shard {wildcards.shard}"


use rule render_phy as render_study_phy with:
    input:
        layers=lambda w: (
            f"results/studies/tracker/{w.setting}/labels/{w.shard}.nc"
            if tracker_runs.draws(ABLATION[w.setting])
            else f"results/labels/{w.shard}.nc"
        ),
        statistics=lambda w: STATISTICS[
            tracker_runs.estimator_of(ABLATION[w.setting], config)
        ],
        code=imported_by("render_phy.py"),
    output:
        scenes="results/studies/tracker/{setting}/phy/{shard}.nc",
    log:
        "logs/render_study_phy/{setting}/{shard}.log",
    benchmark:
        "results/benchmarks/render_study_phy/{setting}/{shard}.tsv"
    resources:
        results_mb=lambda wildcards: scenes_mb("labels", wildcards.shard, 220),
    params:
        phy=lambda w: tracker_runs.phy_of(ABLATION[w.setting], config["phy"]),
        by_other_statistics=lambda w: not tracker_runs.draws(ABLATION[w.setting]),
    message:
        "PHY renders of {wildcards.setting}, shard {wildcards.shard}"


use rule train_tracker as train_study_tracker with:
    input:
        real=real_scenes,
        phy=lambda w: tracker_runs.renders_of(
            w.setting, ABLATION[w.setting], added_scenes("phy")(w)
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
        n_epochs=lambda w: tracker_runs.epochs_of(ABLATION[w.setting], TRACKER),
        data=lambda w: tracker_runs.data_of(ABLATION[w.setting], TRACKER),
        settings=lambda w: tracker_runs.training_of(ABLATION[w.setting], TRACKER),
        skip=lambda w: ABLATION[w.setting].get("skip", 0),
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
        code=imported_by(EVALUATION / "tabulate_ablation.py"),
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
        code=imported_by(EVALUATION / "tabulate_ablation.py"),
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


rule atlas_tracker:
    input:
        train=benchmark_files("train"),
        scenes=benchmark_files("validation"),
        network="results/tracker/rd/0.safetensors",
        statistics="results/statistics.nc",
        code=imported_by(EVALUATION / "atlas_tracker.py"),
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
        rules.atlas_tracker.output,
        rules.plot_study_tracker.output,
    message:
        "what makes synthetic data help or hurt the tracker, its cost and where it fails"


# The conditional GAN: cost and worth beside other renderers, atlas.

CGAN_STUDY = config["studies"]["cgan"]


# A generator without a discriminator, and every renderer of label sets beside the others.


use rule train_cgan as train_l1 with:
    output:
        generator="results/studies/cgan/l1/generator.safetensors",
        losses="results/studies/cgan/l1/losses.csv",
        scores="results/studies/cgan/l1/validation.csv",
        samples="results/studies/cgan/l1/samples.nc",
    log:
        "logs/train_l1.log",
    benchmark:
        "results/benchmarks/train_l1/all.tsv"
    params:
        settings={**CGAN_SETTINGS, **CGAN_STUDY["l1"]},
        on_collapse="go_on",
        checkpoint="results/checkpoints/train_l1.safetensors",
        events="logs/tensorboard/train_l1",
    message:
        "training of the generator without a discriminator"


rule study_renderers:
    input:
        train=benchmark_files("train"),
        validation=benchmark_files("validation"),
        labels=LABEL_FILES,
        statistics="results/statistics.nc",
        cgan="results/cgan/generator.safetensors",
        l1="results/studies/cgan/l1/generator.safetensors",
        code=imported_by(EVALUATION / "study_renderers.py"),
    output:
        costs="results/studies/cgan/renderers.csv",
        positions="results/studies/cgan/positions.csv",
    log:
        "logs/study_renderers.log",
    benchmark:
        "results/benchmarks/study_renderers/all.tsv"
    resources:
        mem_mb=4000,
        gpu=int(config["cgan"]["device"] == "cuda"),
    params:
        seed=config["seed"],
        device=config["cgan"]["device"],
        phy=config["phy"],
        n_range_lines=config["labels"]["n_range_lines"],
        n_layers=N_LAYERS_RANGE,
        first_slab=config["labels"]["first_slab"],
        surface=config["labels"]["surface"],
        correlation=config["labels"]["correlation"],
        radiometry=config["labels"]["radiometry"],
        n_drawn=CGAN_STUDY["n_drawn"],
        n_trainings=CGAN_STUDY["n_trainings"],
        tracker=TRACKER["training"],
        two_sample={
            "n_splits": config["drawn_scenes"]["n_splits"],
            "n_steps": config["drawn_scenes"]["n_steps"],
        },
    message:
        "cost and worth of every renderer, positions of layers"
    script:
        "../scripts/study_renderers.py"


rule study_cgan_atlas:
    input:
        train=cgan_train_files(),
        code=imported_by(EVALUATION / "study_cgan_atlas.py"),
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
        settings={**CGAN_SETTINGS, **CGAN_STUDY["atlas"]["training"]},
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
        rules.study_renderers.output,
        rules.study_cgan_atlas.output,
        rules.plot_study_cgan.output,
    message:
        "studies of the cGAN"


# Scores of every network against the cost of its training.


rule measure_budgets:
    input:
        train=lambda w: (
            cgan_train_files() if w.network == "cgan" else benchmark_files("train")
        ),
        validation=benchmark_files("validation"),
        phy=expand("results/phy/labels/{shard}.nc", shard=shards("labels")),
        code=imported_by(EVALUATION / "study_budgets.py"),
    output:
        table="results/studies/budgets/{network}.csv",
    log:
        "logs/measure_budgets/{network}.log",
    benchmark:
        "results/benchmarks/measure_budgets/{network}.tsv"
    wildcard_constraints:
        network="tracker|cgan",
    resources:
        mem_mb=3000,
    params:
        seed=config["seed"],
        network="{network}",
        settings={"tracker": TRACKER["training"], "cgan": CGAN_SETTINGS},
        changes=lambda w: config["studies"]["budgets"][w.network],
        n_trainings=config["studies"]["budgets"]["n_trainings"],
        n_held=config["cgan"]["validation"]["n_scenes"],
    message:
        "scores of {wildcards.network} by settings that make its training cheaper or dearer"
    script:
        "../scripts/study_budgets.py"


rule study_budgets:
    input:
        rules.plot_study_budgets.output,
    message:
        "budgets of all trainings"


# Waveforms of the nadir altimetry solver of SMRT beside eq. (1) and the nature run: needs the package smrt.


rule study_convolution_smrt:
    input:
        code=imported_by(EVALUATION / "study_convolution_smrt.py"),
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
    message:
        "SMRT beside the convolution model; the figure of the target convolution takes it in when that is run next"


# Random profiles against a coherent solver, by step, lens and band.


rule study_profiles_table:
    input:
        code=imported_by(EVALUATION / "study_profiles.py"),
    output:
        table="results/studies/convolution/profiles.csv",
    log:
        "logs/study_profiles_table.log",
    benchmark:
        "results/benchmarks/study_profiles_table/all.tsv"
    params:
        seed=config["seed"],
        n_profiles=200,
    message:
        "mean power of random profiles, as combined and by a coherent solver"
    script:
        "../scripts/study_profiles.py"


rule study_profiles:
    input:
        rules.plot_study_profiles.output,
    message:
        "how well profiles finer than the range cell are combined, and where not"


rule studies:
    input:
        lambda wildcards: [file for item in targets("study_") for file in item.input],
    message:
        "all studies: hours of trainings, not part of the default run"
