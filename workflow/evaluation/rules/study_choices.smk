# The study of choices: what each part of the scene model is worth to a tracker that is trained on PHY's scenes alone. On
# flights that serve for choosing, the part is left out of the statistics, scenes are drawn and rendered anew, and
# trackers that are trained on these are scored on validation scenes. Beside it, how often a network tells such scenes from
# observed ones.

from evaluation.lib import choices

CHOSEN = config["studies"]["choices"]
CHOSEN_ON = flights.flights_of(CHOSEN["first_seed"], CHOSEN["n_flights"])
PARTS = [choices.WHOLE, *choices.PARTS]


wildcard_constraints:
    part="|".join(PARTS),


# One flight: scenes without the part, trackers, scores.


rule leave_out:
    input:
        statistics="results/statistics.nc",
    output:
        statistics="results/choices/{part}/statistics.nc",
    log:
        "logs/leave_out/{part}.log",
    benchmark:
        "results/benchmarks/leave_out/{part}.tsv"
    params:
        part="{part}",
    message:
        "statistics without {wildcards.part}"
    script:
        "../scripts/leave_out.py"


use rule draw_labels as draw_without with:
    input:
        statistics=rules.leave_out.output.statistics,
    output:
        labels="results/choices/{part}/labels/{shard}.nc",
    log:
        "logs/draw_without/{part}/{shard}.log",
    benchmark:
        "results/benchmarks/draw_without/{part}/{shard}.tsv"
    message:
        "label sets without {wildcards.part}, shard {wildcards.shard}"


use rule render_phy as render_without with:
    input:
        layers=rules.draw_without.output.labels,
        statistics=rules.leave_out.output.statistics,
    output:
        scenes="results/choices/{part}/phy/{shard}.nc",
    log:
        "logs/render_without/{part}/{shard}.log",
    benchmark:
        "results/benchmarks/render_without/{part}/{shard}.tsv"
    resources:
        results_mb=lambda w: scenes_mb("labels", w.shard, 220),
    message:
        "PHY renders without {wildcards.part}, shard {wildcards.shard}"


use rule train_tracker as train_without with:
    input:
        real=[],
        phy=expand("results/choices/{{part}}/phy/{shard}.nc", shard=shards("labels")),
        cgan=[],
        own=[],
    output:
        network="results/choices/{part}/{replica}.safetensors",
        losses="results/choices/{part}/{replica}_losses.csv",
    log:
        "logs/train_without/{part}/{replica}.log",
    benchmark:
        "results/benchmarks/train_without/{part}/{replica}.tsv"
    params:
        n_epochs=None,
        settings=TRACKER["training"] | {"n_steps": CHOSEN["n_gradients"]},
        checkpoint=f"{CHECKPOINTS}/train_without_{{part}}_{{replica}}.safetensors",
        events=f"{EVENTS}/train_without/{{part}}/{{replica}}",
    message:
        "tracker on scenes without {wildcards.part}, replica {wildcards.replica}"


use rule score_studied as score_without with:
    input:
        networks=expand("results/choices/{{part}}/{replica}.safetensors", replica=REPLICAS),
        scenes=benchmark_files("validation"),
        validation=benchmark_files("validation"),
    output:
        scores="results/choices/{part}/scores.csv",
        depths="results/choices/{part}/depths.csv",
    log:
        "logs/score_without/{part}.log",
    benchmark:
        "results/benchmarks/score_without/{part}.tsv"
    params:
        labels=lambda w: {"training_set": w.part},
    message:
        "edge scores without {wildcards.part}"


use rule compare_scenes as compare_without with:
    input:
        observed=benchmark_files("train"),
        phy=lambda w: expand(rules.render_without.output.scenes, part=w.part, shard=DRAWN_SHARDS),
    output:
        two_sample="results/choices/{part}/two_sample.csv",
    log:
        "logs/compare_without/{part}.log",
    benchmark:
        "results/benchmarks/compare_without/{part}.tsv"
    message:
        "scenes without {wildcards.part} beside observed ones: can they be distinguished"


rule score_choices:
    input:
        scores=expand("results/choices/{part}/scores.csv", part=PARTS),
        depths=expand("results/choices/{part}/depths.csv", part=PARTS),
        two_sample=expand("results/choices/{part}/two_sample.csv", part=PARTS),
    output:
        scores="results/one_flight/choices.csv",
        depths="results/one_flight/choices_depths.csv",
    log:
        "logs/score_choices.log",
    benchmark:
        "results/benchmarks/score_choices/all.tsv"
    message:
        "edge scores and distinguished scenes without each part"
    script:
        "../scripts/score_choices.py"


# All flights.


rule tabulate_choices:
    input:
        scores=expand(rules.fly.output.scores, study="choices", flight=CHOSEN_ON),
    output:
        losses="results/studies/choices/losses.csv",
    log:
        "logs/tabulate_choices.log",
    benchmark:
        "results/benchmarks/tabulate_choices/all.tsv"
    params:
        flights=CHOSEN_ON,
    message:
        "loss without each part of the scene model"
    script:
        "../scripts/tabulate_choices.py"


rule study_choices:
    input:
        rules.tabulate_choices.output,
    message:
        "worth of each part of the scene model: 2 hours on two cores"
