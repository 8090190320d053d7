"""Triangles of even size on a given surface: split long edges, collapse short ones, flip bad ones.

Vertices only ever lie on the given surface and none is moved, so that corners, knuckles and the
waterline stay where they are (after Hoppe et al. 1993, with Botsch and Kobbelt's edge lengths).
"""

import numpy as np
from numpy.typing import NDArray

from marine_mj.frames import Array

#: An edge between faces that turn by more than this is a knuckle and stays.
KNUCKLE = np.cos(np.radians(35.0))
#: Along a knuckle or border a vertex may go if the line turns by less than this there.
BEND = np.cos(np.radians(20.0))
#: How far, in panel sizes, a removed vertex may lie off the new faces.
SAG = 0.06


def remesh(points: Array, faces: NDArray, size: float, rounds: int = 3) -> tuple[Array, NDArray]:
    """Points (n, 3) and faces (m, 3) of a surface with edges of about `size` m.

    Panels stay smaller where the surface is curved or has details: no removed vertex is farther
    than 6 % of `size` from the faces that take its place.

    Args:
        points: (n, 3) m.
        faces: (m, 3), wound consistently; the surface may be open.
        size: wanted length of the edges, m.
        rounds: passes of splitting, collapsing and flipping.
    """
    work = _Surface(np.asarray(points, dtype=float), np.asarray(faces))
    for _ in range(rounds):
        work.split(1.4 * size)
        work.collapse(0.75 * size, size)
        work.flip()
    return work.arrays()


class _Surface:
    """Triangles by number, and the triangles around every vertex."""

    def __init__(self, points: Array, faces: NDArray):
        self.points = list(points)
        self.faces: dict[int, tuple[int, int, int]] = {}
        self.around: dict[int, set[int]] = {}
        self.next = 0
        for a, b, c in faces.tolist():
            self.add(a, b, c)

    def add(self, a: int, b: int, c: int) -> None:
        self.faces[self.next] = (a, b, c)
        for v in (a, b, c):
            self.around.setdefault(v, set()).add(self.next)
        self.next += 1

    def remove(self, face: int) -> None:
        for v in self.faces.pop(face):
            self.around[v].discard(face)

    def shared(self, u: int, v: int) -> list[int]:
        """Faces at an edge, in the order in which they were made."""
        return sorted(self.around[u] & self.around[v])

    def edges(self) -> list[tuple[float, int, int]]:
        """Length and ends of every edge, shortest first."""
        pairs = {
            (min(u, v), max(u, v))
            for a, b, c in self.faces.values()
            for u, v in ((a, b), (b, c), (c, a))
        }
        return sorted((self.length(u, v), u, v) for u, v in pairs)

    def length(self, u: int, v: int) -> float:
        d = self.points[u] - self.points[v]
        return float(np.sqrt(d @ d))

    def normal(self, a: int, b: int, c: int) -> tuple[Array, float]:
        """Unit normal and twice the area."""
        p, q, r = self.points[a], self.points[b], self.points[c]
        (ux, uy, uz), (vx, vy, vz) = (q - p).tolist(), (r - p).tolist()
        n = np.array([uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx])
        size = float(np.sqrt(n @ n))
        return n / max(size, 1e-300), size

    def neighbours(self, u: int) -> set[int]:
        return {v for f in self.around[u] for v in self.faces[f]} - {u}

    def fixed_line(self, u: int) -> list[int]:
        """Other ends of the border and knuckle edges at a vertex."""
        ends = []
        for v in sorted(self.neighbours(u)):
            at = self.shared(u, v)
            if len(at) != 2:
                ends.append(v)
                continue
            (n, _), (m, _) = (self.normal(*self.faces[f]) for f in at)
            if n @ m < KNUCKLE:
                ends.append(v)
        return ends

    def split(self, longest: float) -> None:
        """Halve edges until none is longer, the longest of a pass first."""
        while True:
            long = [e for e in self.edges() if e[0] > longest]
            if not long:
                return
            for _, u, v in reversed(long):
                middle = len(self.points)
                at = self.shared(u, v)
                # Halve an edge only where it is the longest of its faces: no slivers.
                rest = [self.length(*e) for f in at for e in self._sides(f)]
                if max(rest) > self.length(u, v) * (1 + 1e-9):
                    continue
                self.points.append(0.5 * (self.points[u] + self.points[v]))
                for f in at:
                    a, b, c = self.faces[f]
                    self.remove(f)
                    for old in (u, v):
                        self.add(*(middle if w == old else w for w in (a, b, c)))

    def _sides(self, face: int) -> list[tuple[int, int]]:
        a, b, c = self.faces[face]
        return [(a, b), (b, c), (c, a)]

    def collapse(self, shortest: float, size: float) -> None:
        """Merge the ends of short edges, where the surface allows it."""
        for _, u, v in self.edges():
            if u not in self.around or v not in self.around or not self.shared(u, v):
                continue
            if self.length(u, v) >= shortest:
                continue
            if not self._merge(u, v, size):
                self._merge(v, u, size)

    def _merge(self, u: int, v: int, size: float) -> bool:
        """Move vertex u into v if corners, lines and shape survive."""
        at = self.shared(u, v)
        if len(self.neighbours(u) & self.neighbours(v)) != len(at):
            return False
        line = self.fixed_line(u)
        if line:
            if len(line) != 2 or v not in line:
                return False
            other = line[0] if line[1] == v else line[1]
            d, e = self.points[v] - self.points[u], self.points[u] - self.points[other]
            if d @ e < BEND * self.length(u, v) * self.length(u, other):
                return False
        made = []
        for f in sorted(self.around[u]):
            if f in at:
                continue
            before, old_area = self.normal(*self.faces[f])
            after = tuple(v if w == u else w for w in self.faces[f])
            n, area = self.normal(*after)  # type: ignore[arg-type]
            sides = [self.length(after[i], after[i - 1]) for i in range(3)]
            slender = area < 0.15 * max(sides) ** 2 and area < old_area
            turned = old_area > 1e-9 * size**2 and n @ before < 0.75
            off = abs(float(n @ (self.points[u] - self.points[v])))
            if turned or slender or max(sides) > 1.4 * size or off > SAG * size:
                return False
            made.append(after)
        if not made:
            return False
        for f in list(self.around[u]):
            self.remove(f)
        del self.around[u]
        for after in made:
            self.add(*after)
        return True

    def flip(self) -> None:
        """Swap the diagonal of two flat neighbours where that widens the smallest angle."""
        for _, u, v in reversed(self.edges()):
            at = self.shared(u, v)
            if len(at) != 2:
                continue
            (n, _), (m, _) = (self.normal(*self.faces[f]) for f in at)
            if n @ m < np.cos(np.radians(15.0)):
                continue
            a, b = (next(w for w in self.faces[f] if w not in (u, v)) for f in at)
            if a == b or self.shared(a, b):
                continue
            face = self.faces[at[0]]
            first, last = (u, v) if face[face.index(u) - 2] == v else (v, u)
            new = (a, first, b), (b, last, a)
            worst_before = min(self.shape(self.faces[f]) for f in at)
            if min(self.shape(t) for t in new) <= worst_before * (1 + 1e-9):
                continue
            if min(self.normal(*t)[0] @ n for t in new) < 0.9:
                continue
            for f in at:
                self.remove(f)
            for t in new:
                self.add(*t)

    def shape(self, face: tuple[int, int, int]) -> float:
        """Area over the sum of the squared sides: largest for an equilateral triangle."""
        a, b, c = face
        sides = sum(self.length(p, q) ** 2 for p, q in ((a, b), (b, c), (c, a)))
        return self.normal(a, b, c)[1] / max(sides, 1e-300)

    def arrays(self) -> tuple[Array, NDArray]:
        faces = np.array([self.faces[f] for f in sorted(self.faces)], dtype=int)
        used, index = np.unique(faces, return_inverse=True)
        return np.array(self.points)[used], index.reshape(-1, 3)
