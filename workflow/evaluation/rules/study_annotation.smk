# The study of annotation: what PHY's scenes are worth to those who have few annotated ones. Trackers on the first scenes of
# RD, alone and with PHY's, scored on validation scenes of the default flight and of another. Pages show the scores that are
# kept in workflow/evaluation: put results/studies/annotation/scores.csv in place of measured_annotation.csv.

ANNOTATED = config["studies"]["annotation"]
ANNOTATED_ON = list(map(str, ANNOTATED["flights"]))
CURVE = [
    (studied.first_scenes(each["n_scenes"], with_pd), n)
    for each in ANNOTATED["sets"]
    for with_pd, kind in enumerate(("alone", "with_pd"))
    for n in each[kind]
]


use rule score_flight as score_annotation with:
    input:
        scores=studied.scored(CURVE, "validation", "scores"),
        depths=studied.scored(CURVE, "validation", "depths"),
    output:
        scores="results/one_flight/annotation.csv",
        depths="results/one_flight/annotation_depths.csv",
    log:
        "logs/score_annotation.log",
    benchmark:
        "results/benchmarks/score_annotation/all.tsv"
    message:
        "edge scores by number of annotated scenes"


rule tabulate_annotation:
    input:
        scores=expand(rules.fly.output.scores, study="annotation", flight=ANNOTATED_ON),
    output:
        **drawn("study_annotation", "annotation.svg"),
        scores="results/studies/annotation/scores.csv",
        curve="results/studies/annotation/curve.csv",
    log:
        "logs/tabulate_annotation.log",
    benchmark:
        "results/benchmarks/tabulate_annotation/all.tsv"
    params:
        flights=ANNOTATED_ON,
        source=NOTE,
    message:
        "worth of PHY's scenes by number of annotated ones: table and figure"
    script:
        "../scripts/tabulate_annotation.py"


rule study_annotation:
    input:
        rules.tabulate_annotation.output,
    message:
        "worth of PHY's scenes by number of annotated ones: 1.5 hours on two cores"
