# From the flight to Tables II and III: what a run cannot do without, and what may be run beside itself as a module.


include: "common.smk"
include: "flight.smk"
include: "labels.smk"
include: "renders.smk"
include: "similarity.smk"
include: "tracker.smk"
