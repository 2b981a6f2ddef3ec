"""Edge scores of trackers.

Suppression to one-pixel edges, exact one-to-one matching, ODS, OIS and AP.

The chain of one image is ``match_counts(suppress(prediction), truth, THRESHOLDS)``. Counts are
plain integers, so images may be counted in any order, in shards, and pooled later by `score`.
"""

from snowsim.metrics.edges.counts import THRESHOLDS, match_counts
from snowsim.metrics.edges.scores import COUNTS, precision_recall, score, stack_counts
from snowsim.metrics.edges.suppression import suppress
from snowsim.metrics.edges.thinning import thin

__all__ = [
    "COUNTS",
    "THRESHOLDS",
    "match_counts",
    "precision_recall",
    "score",
    "stack_counts",
    "suppress",
    "thin",
]
