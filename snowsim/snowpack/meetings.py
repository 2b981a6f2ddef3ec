"""Places where tracks meet: crossings, and overlaps of tracks that were flown twice.

Positions are unit vectors, so that poles and the antimeridian are places like any other.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree
from scipy.spatial.distance import cdist

from snowsim.alignment import positions_of
from snowsim.constants import EARTH_RADIUS_M

# Tracks overlap if they stay together for so many times the distance within which they meet, as
# those do that cross at less than 6 degrees. An overlap has a place in each such length.
OVERLAP_REACHES = 20
# Lines of one track are two passes if so many times that distance of track lies between them.
APART_REACHES = 10
NODE_REACHES = 0.5  # length of track that one node of the k-d tree stands for


@dataclass(frozen=True, eq=False)
class Track:
    """Range lines of a segment that have a position.

    `line` is their number in the segment, `vector` (line, 3) their position on the unit sphere,
    and `along_m` their distance along track from the first.
    """

    line: np.ndarray
    vector: np.ndarray
    along_m: np.ndarray

    def lines_about(self, index, reach_m):
        """Slice of the lines within a distance along track of one of them [m]."""
        ends_m = self.along_m[index] + np.array([-reach_m, reach_m])
        start = np.searchsorted(self.along_m, ends_m[0])
        return slice(start, np.searchsorted(self.along_m, ends_m[1], "right"))

    def direction(self, index, reach_m):
        """Unit vector (3,) of the direction of flight, over the lines within a distance [m]."""
        about = self.vector[self.lines_about(index, reach_m)]
        step = about[-1] - about[0]
        length = np.linalg.norm(step)
        return step / length if length > 0 else np.full(3, np.nan)


@dataclass(frozen=True)
class Place:
    """A range line each of two passes over the same place.

    `first` and `second` number tracks, `index_first` and `index_second` the lines in them.
    `meeting` numbers crossings and overlaps; `length_m` is that of the whole meeting. The angle is
    that between both directions of flight, 0 to 180.
    """

    first: int
    second: int
    index_first: int
    index_second: int
    meeting: int
    length_m: float
    is_overlap: bool
    distance_m: float
    angle_deg: float


def track_of(layers):
    """`Track` of a dataset with positions; ValueError if no range line has one."""
    if not {"Latitude", "Longitude"} <= set(layers):
        msg = "Latitude and Longitude: expected those of range lines, found none"
        raise ValueError(msg)
    north, east = positions_of(layers)
    line = np.flatnonzero(np.isfinite(north) & np.isfinite(east))
    if line.size == 0:
        msg = "Latitude and Longitude: expected those of a range line, all are missing"
        raise ValueError(msg)
    north, east = north[line], east[line]
    vector = np.stack(
        [np.cos(north) * np.cos(east), np.cos(north) * np.sin(east), np.sin(north)], axis=1
    )
    steps_m = _arc_m(np.linalg.norm(np.diff(vector, axis=0), axis=1))
    return Track(line, vector, np.append(0, np.cumsum(steps_m)))


def _arc_m(chord):
    """Length on the ground [m] of chords of the unit sphere."""
    return 2 * EARTH_RADIUS_M * np.arcsin(np.minimum(chord / 2, 1))


def find_places(tracks, within_m):
    """List of `Place` at which two tracks, or two parts of one, lie within a distance [m].

    A crossing has one place, where the tracks are nearest. An overlap has one in every 20 times
    `within_m`, in the middle of that stretch.
    """
    nodes = _Nodes.of(tracks, NODE_REACHES * within_m)
    pairs = nodes.near_pairs(tracks, within_m)
    if len(pairs) == 0:
        return []
    # Nodes of different tracks have numbers that do not follow one another.
    group = _connected(pairs + nodes.track[pairs])
    order = np.argsort(group, kind="stable")
    starts = np.flatnonzero(np.diff(group[order], prepend=-1))
    meetings = [
        _places_of_meeting(tracks, nodes, own, within_m)
        for own in np.split(pairs[order], starts[1:])
    ]
    meetings = sorted((own for own in meetings if own), key=_order)
    return [Place(**place, meeting=number) for number, own in enumerate(meetings) for place in own]


def _order(meeting):
    """Key by which meetings are ordered: by their tracks, then by their range lines."""
    return tuple(meeting[0][name] for name in ("first", "second", "index_first", "index_second"))


@dataclass(frozen=True, eq=False)
class _Nodes:
    """Short stretches of all tracks, (node,): track, first line, line after the last."""

    track: np.ndarray
    start: np.ndarray
    stop: np.ndarray

    @classmethod
    def of(cls, tracks, length_m):
        """Nodes of a length along track [m], at least one range line each."""
        starts = [
            np.flatnonzero(np.diff(track.along_m // length_m, prepend=-1)) for track in tracks
        ]
        stops = [
            np.append(start[1:], track.line.size)
            for start, track in zip(starts, tracks, strict=True)
        ]
        number = np.repeat(np.arange(len(tracks)), [start.size for start in starts])
        return cls(number, np.concatenate(starts), np.concatenate(stops))

    def values(self, tracks, name):
        """An attribute of the first line of every node."""
        starts = np.split(self.start, np.flatnonzero(np.diff(self.track)) + 1)
        own = [getattr(track, name)[start] for track, start in zip(tracks, starts, strict=True)]
        return np.concatenate(own)

    def near_pairs(self, tracks, within_m):
        """Pairs of nodes (pair, 2) that may hold lines within a distance [m] of each other."""
        reach_m = (1 + 2 * NODE_REACHES) * within_m
        chord = 2 * np.sin(min(reach_m / (2 * EARTH_RADIUS_M), np.pi / 2))
        tree = KDTree(self.values(tracks, "vector"))
        pairs = tree.query_pairs(chord, output_type="ndarray")
        apart_m = np.abs(np.diff(self.values(tracks, "along_m")[pairs], axis=1)[:, 0])
        is_same = self.track[pairs[:, 0]] == self.track[pairs[:, 1]]
        return pairs[~is_same | (apart_m > APART_REACHES * within_m)]


def _connected(pairs):
    """Group (pair,) of pairs of numbers: those of one group are linked by steps of 1 in both."""
    links = KDTree(pairs).query_pairs(1, p=np.inf, output_type="ndarray")
    linked = coo_array((np.ones(len(links), bool), links.T), shape=(len(pairs), len(pairs)))
    return connected_components(linked, directed=False)[1]


def _places_of_meeting(tracks, nodes, pairs, within_m):
    """Attributes of the places of one meeting, list of dict, from its pairs of nodes."""
    first, second = nodes.track[pairs[0]]
    longest_m = OVERLAP_REACHES * within_m
    along_m = tracks[first].along_m[nodes.start[pairs[:, 0]]]
    extent_m = np.ptp(along_m)
    n_pieces = max(1, int(extent_m / longest_m))
    piece = np.zeros(len(pairs), int)
    if n_pieces > 1:
        piece = np.minimum(n_pieces * (along_m - along_m.min()) / extent_m, n_pieces - 1)
    stretches = [
        _Stretch.of(tracks, nodes, pairs[piece.astype(int) == number], within_m)
        for number in range(n_pieces)
    ]
    met = [stretch for stretch in stretches if stretch.lines.size]
    if not met:
        return []
    ends_m = tracks[first].along_m[[met[0].lines[0], met[-1].lines[-1]]]
    common = {
        "first": int(first),
        "second": int(second),
        "length_m": float(np.ptp(ends_m)),
        "is_overlap": bool(np.ptp(ends_m) > longest_m),
    }
    places = []
    for stretch in met:
        at = stretch.nearest if len(met) == 1 else stretch.middle
        indices = {"index_first": int(stretch.lines[at]), "index_second": int(stretch.beside[at])}
        one = tracks[first].direction(indices["index_first"], within_m)
        other = tracks[second].direction(indices["index_second"], within_m)
        angle = float(np.degrees(np.arccos(np.clip(one @ other, -1, 1))))
        at_place = {"distance_m": float(stretch.distance_m[at]), "angle_deg": angle}
        places.append(common | indices | at_place)
    return places


@dataclass(frozen=True, eq=False)
class _Stretch:
    """Lines of the first track within reach of the second, and their nearest lines there, (line,).

    Both are indices in their tracks; `distance_m` is the distance between them.
    """

    lines: np.ndarray
    beside: np.ndarray
    distance_m: np.ndarray

    @classmethod
    def of(cls, tracks, nodes, pairs, within_m):
        """The lines of pairs of nodes that are within reach of each other."""
        if len(pairs) == 0:
            return cls(*np.empty((3, 0)))
        first, second = (tracks[number] for number in nodes.track[pairs[0]])
        ours, theirs = (np.arange(nodes.start[own].min(), nodes.stop[own].max()) for own in pairs.T)
        distance_m = _arc_m(cdist(first.vector[ours], second.vector[theirs]))
        if first is second:
            apart_m = np.abs(first.along_m[ours, None] - first.along_m[theirs])
            distance_m[apart_m <= APART_REACHES * within_m] = np.inf
        nearest = distance_m.argmin(axis=1)
        least_m = distance_m[np.arange(ours.size), nearest]
        met = least_m <= within_m
        return cls(ours[met], theirs[nearest[met]], least_m[met])

    @property
    def nearest(self):
        """Index of the line that is nearest to the other track."""
        return int(self.distance_m.argmin())

    @property
    def middle(self):
        """Index of the line in the middle of the stretch."""
        return self.lines.size // 2
