"""Edge scores of trackers: suppression to thin edges, one-to-one matching, ODS, OIS and AP.

``match_counts(suppress(prediction), truth, THRESHOLDS)`` counts one image as published. By default,
`thresholds_of` all images that are scored together replaces `THRESHOLDS`. Counts are integers, so
images may be counted in any order and in shards; `score` pools them.
"""

from snowsim.metrics.edges.counts import THRESHOLDS, match_counts, thresholds_of
from snowsim.metrics.edges.scores import (
    COUNTS,
    METRICS,
    f_measure,
    precision_recall,
    score,
    select_images,
    stack_counts,
)
from snowsim.metrics.edges.suppression import CURVATURE, suppress

__all__ = [
    "COUNTS",
    "CURVATURE",
    "METRICS",
    "THRESHOLDS",
    "f_measure",
    "match_counts",
    "select_images",
    "precision_recall",
    "score",
    "stack_counts",
    "suppress",
    "thresholds_of",
]
