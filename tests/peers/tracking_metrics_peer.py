"""Metrics of random pairs of curves: IoU and Hausdorff by shapely, Chamfer by scipy, Fréchet by similaritymeasures."""

import json
import pathlib
import subprocess
import sys

import numpy as np
import shapely
from scipy.spatial import cKDTree
from shapely.ops import polygonize, unary_union
from similaritymeasures import frechet_dist

COUNT = 50
# Both compute distances of curves of size 10 in doubles.
ROUNDING = 1e-12
# Areas of size 100 in doubles, cut into up to a few hundred pieces, over areas that are larger than 1.
AREA = 1e-12
# Distance of the points that stand for a line in the peer's Chamfer distance.
SPACING = 1e-3


def wobbly(rng):
    """A closed curve around the origin, smooth, and crossing itself now and then."""
    angle = np.linspace(0, 2 * np.pi, rng.integers(40, 200), endpoint=False)
    lobes = rng.integers(1, 4)
    curve = np.zeros((len(angle), 2))
    for k in range(1, 5):
        amplitude, phase = rng.normal(0, 4.0 / k, 2), rng.uniform(0, 2 * np.pi, 2)
        curve += amplitude * np.cos(lobes * k * angle[:, None] + phase) if k > 1 else 6 * np.cos(k * angle[:, None] + phase)
    return curve


def jagged(rng):
    """Points at random, crossing at every turn."""
    return rng.uniform(-10, 10, (rng.integers(4, 30), 2))


def even_odd(points):
    """The region that a closed curve goes around an odd number of times."""
    ring = np.vstack([points, points[:1]])
    faces = polygonize(unary_union([shapely.LineString(pair) for pair in zip(ring[:-1], ring[1:])]))

    def is_inside(face):
        x, y = face.representative_point().coords[0]
        (x0, y0), (x1, y1) = ring[:-1].T, ring[1:].T
        cuts = (y0 > y) != (y1 > y)
        at = x0[cuts] + (y - y0[cuts]) / (y1[cuts] - y0[cuts]) * (x1[cuts] - x0[cuts])
        return np.count_nonzero(at > x) % 2 == 1

    return unary_union([face for face in faces if is_inside(face)])


def iou(a, b):
    a, b = even_odd(a), even_odd(b)
    return a.intersection(b).area / a.union(b).area


def chamfer(a, b):
    def mean(points, line):
        line = shapely.LineString(line)
        dense = shapely.line_interpolate_point(line, np.arange(0, line.length, SPACING))
        dense = np.vstack([shapely.get_coordinates(dense), line.coords[-1]])
        return cKDTree(dense).query(points)[0].mean()

    return (mean(a, b) + mean(b, a)) / 2


def frechet_closed(a, b):
    """Of closed curves: the best of all beginnings of the second, each walked back to where it began."""
    closed = np.vstack([a, a[:1]])
    turned = (np.vstack([b[k:], b[: k + 1]]) for k in range(len(b)))
    return min(frechet_dist(closed, curve) for curve in turned)


def main():
    program = pathlib.Path(sys.argv[1])
    rng = np.random.default_rng(20)
    pairs = [(draw(rng), draw(rng)) for draw in (wobbly, jagged) for _ in range(COUNT // 2)]
    example = program.parent / "examples" / "tracking_metrics"
    lines = "\n".join(json.dumps({"a": a.tolist(), "b": b.tolist()}) for a, b in pairs)
    done = subprocess.run([example], input=lines.encode(), check=True, stdout=subprocess.PIPE)
    found = [json.loads(line) for line in done.stdout.splitlines()]
    assert len(found) == COUNT

    peers = {
        "iou": (iou, AREA),
        "hausdorff": (lambda a, b: shapely.hausdorff_distance(shapely.LineString(a), shapely.LineString(b)), ROUNDING),
        # A point of the line is at most half a spacing from one that stands for it.
        "chamfer": (chamfer, SPACING / 2),
        "frechet": (frechet_dist, ROUNDING),
    }
    for name, (peer, tolerance) in peers.items():
        worst = max(abs(own[name] - peer(a, b)) for own, (a, b) in zip(found, pairs))
        print(f"{name}: {COUNT} pairs of curves within {worst:.1e}, allowed {tolerance:.1e}")
        assert worst <= tolerance, name
    # Every beginning costs the peer a whole table: the shorter curves will do.
    short = [(own, a, b) for own, (a, b) in zip(found, pairs) if len(a) * len(b) ** 2 < 30**3]
    worst = max(abs(own["frechet_closed"] - frechet_closed(a, b)) for own, a, b in short)
    print(f"frechet_closed: {len(short)} pairs of closed curves within {worst:.1e}, allowed {ROUNDING:.1e}")
    assert len(short) > 10 and worst <= ROUNDING


main()
