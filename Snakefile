# snowsim: from one annotated Snow Radar flight to synthetic echograms, and what they do for a layer tracker.


configfile: f"{workflow.basedir}/config/config.yaml"


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
include: "workflow/rules/evidence.smk"
include: "workflow/rules/paper_figures.smk"


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
    evidence,
    paper_figures,
    report,


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
        rules.evidence.input,
        rules.paper_figures.input,
        "results/report.html",


include: "workflow/rules/report.smk"
