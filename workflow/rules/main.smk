# From sums over the flight to Tables II and III: what a run may do beside itself, with other settings, as a module.


include: "common.smk"
include: "labels.smk"
include: "renders.smk"
include: "similarity.smk"
include: "tracker.smk"
