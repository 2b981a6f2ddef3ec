# The way from summaries of the flight to Tables II and III, which a run can take again as a module with other settings.


include: "common.smk"
include: "labels.smk"
include: "renders.smk"
include: "similarity.smk"
include: "tracker.smk"
