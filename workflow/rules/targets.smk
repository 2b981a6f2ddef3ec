# Targets that collect others: all studies there are, and the list of targets. Included last.

STUDY_PREFIX = "study_"


rule studies:
    input:
        lambda wildcards: [
            file for item in targets(prefix=STUDY_PREFIX) for file in item.input
        ],
    message:
        "all studies: hours of trainings, not part of the default run"


rule help:
    params:
        targets=lambda wildcards: describe_targets(),
    message:
        "{params.targets}"
