"""Edge scores of trackers: suppression to thin edges, one-to-one matching, ODS, OIS and AP.

One image is counted by ``match_counts(suppress(prediction), truth, THRESHOLDS)``. Counts are
integers, so images may be counted in any order and in shards; `score` pools them.
"""

from snowsim.metrics.edges.counts import THRESHOLDS, match_counts
from snowsim.metrics.edges.scores import COUNTS, METRICS, precision_recall, score, stack_counts
from snowsim.metrics.edges.suppression import suppress
from snowsim.metrics.edges.thinning import thin

__all__ = [
    "COUNTS",
    "METRICS",
    "THRESHOLDS",
    "match_counts",
    "precision_recall",
    "score",
    "stack_counts",
    "suppress",
    "thin",
]
