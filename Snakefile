# snowsim: from one annotated Snow Radar flight to synthetic echograms, and what they do for a layer tracker.


configfile: f"{workflow.current_basedir.get_path_or_uri(secret_free=False)}/config/config.yaml"


include: "workflow/rules/main.smk"
include: "workflow/rules/flight.smk"
include: "workflow/rules/figures.smk"
include: "workflow/rules/diagnostics.smk"
include: "workflow/rules/export.smk"
include: "workflow/rules/studies.smk"
include: "workflow/rules/as_printed.smk"


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
    localrule: True
    message:
        "both tables, every figure and the report (default)"


rule studies:
    input:
        lambda wildcards: [file for item in targets("study_") for file in item.input],
    localrule: True
    message:
        "all studies: hours of trainings, not part of the default run"


rule help:
    localrule: True
    params:
        targets=lambda wildcards: describe_targets(),
    message:
        "{params.targets}"


include: "workflow/rules/report.smk"


# Every script runs in one environment.
for item in workflow.rules:
    if item.script and Path(item.snakefile).is_relative_to(ROOT):
        item.conda_env = str(ROOT / "envs/cpu.yaml")
