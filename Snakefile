# snowsim: from one annotated Snow Radar flight to synthetic echograms, and what they do for a layer tracker.


configfile: f"{workflow.current_basedir.get_path_or_uri(secret_free=False)}/config/config.yaml"


include: "workflow/rules/common.smk"
include: "workflow/rules/flight.smk"
include: "workflow/rules/statistics.smk"
include: "workflow/rules/labels.smk"
include: "workflow/rules/phy.smk"
include: "workflow/rules/cgan.smk"
include: "workflow/rules/similarity.smk"
include: "workflow/rules/tracker.smk"
include: "workflow/rules/charts.smk"
include: "workflow/rules/stability.smk"
include: "workflow/rules/phy_charts.smk"
include: "workflow/rules/closed_loop.smk"
include: "workflow/rules/realism.smk"
include: "workflow/rules/targets.smk"
include: "workflow/rules/guards.smk"


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
    closed_loop,
    realism,
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
        rules.realism.input,
    message:
        "both tables and every figure: the default"
