# snowsim: from one annotated Snow Radar flight to synthetic echograms, and what they do for a layer tracker.


configfile: f"{workflow.current_basedir.get_path_or_uri(secret_free=False)}/config/config.yaml"


include: "workflow/rules/common.smk"
include: f"workflow/rules/{FLIGHT_RULES[SOURCE]}.smk"
include: "workflow/rules/statistics.smk"
include: "workflow/rules/labels.smk"
include: "workflow/rules/phy.smk"
include: "workflow/rules/cgan.smk"
include: "workflow/rules/similarity.smk"
include: "workflow/rules/tracker.smk"
include: "workflow/rules/stability.smk"
include: "workflow/rules/stability_statistics.smk"
include: "workflow/rules/phy_charts.smk"
include: "workflow/rules/closed_loop.smk"
include: "workflow/rules/validation.smk"
include: "workflow/rules/realism.smk"
include: "workflow/rules/export.smk"
include: "workflow/rules/study_tracker.smk"
include: "workflow/rules/evidence.smk"
include: "workflow/rules/convolution.smk"
include: "workflow/rules/study_convolution.smk"
include: "workflow/rules/study_cgan.smk"
include: "workflow/rules/targets.smk"
include: "workflow/rules/guards.smk"
include: "workflow/rules/figures.smk"


localrules:
    all,
    flight,
    labels,
    renders,
    similarity,
    trackers,
    charts,
    charts_phy,
    stability,
    stability_statistics,
    closed_loop,
    validation,
    realism,
    export,
    study_tracker,
    evidence,
    report,
    convolution,
    study_convolution,
    study_cgan,
    studies,
    help,


rule all:
    default_target: True
    input:
        rules.similarity.input,
        rules.trackers.input,
        rules.labels.input,
        rules.renders.input,
        rules.charts.input,
        rules.charts_phy.input,
        rules.stability.input,
        rules.closed_loop.input,
        *([] if "realism" in LEFT_OUT[SOURCE] else rules.realism.input),
        rules.evidence.input,
        rules.validation.input,
        rules.convolution.input,
        "results/report.html",
    message:
        "both tables, every figure and the report (default)"


include: "workflow/rules/report.smk"
