"""Visual meshes of the funnel: `python assets/make_funnel.py`."""

import numpy as np
import trimesh
from shapes import ball, both, box, join, path, place, revolve, tube, write

HULL_BOTTOM = -0.3  # z of the carrier's hull bottom, m


def hoop(x, radius, bar=0.018):
    """Ring about the x axis."""
    ring = trimesh.creation.torus(radius, bar, major_sections=48, minor_sections=10)
    return place(ring, (x, 0, 0), (0, 1, 0), 90)


def main() -> None:
    """Cone and tube of bars, hoops, struts up to the hull."""
    mouth, throat, end = (-0.55, 0.464), (0.0, 0.122), (0.30, 0.122)
    bars, lamps = [], ([], [])
    for i in range(16):
        angle = 2 * np.pi * (i + 0.5) / 16
        c, s = np.cos(angle), np.sin(angle)
        points = [(x, r * c, r * s) for x, r in (mouth, throat, end)]
        bars.append(path(points, 0.0135))
        if i % 2 == 0:
            lamps[int(c < 0)].append(ball((-0.562, 0.48 * c, 0.48 * s), 0.026))
    hoops = join(
        hoop(-0.55, 0.484, 0.02),
        hoop(-0.275, 0.318, 0.014),
        hoop(0.0, 0.145, 0.016),
        hoop(0.15, 0.145, 0.014),
        hoop(0.30, 0.145, 0.016),
    )
    top = HULL_BOTTOM + 1.05

    def struts(side):
        fore = [(0.28, 0.03 * side, 0.15), (0.42, 0.16 * side, top)]
        middle = [(0.0, 0.06 * side, 0.14), (-0.05, 0.30 * side, top)]
        aft = [(-0.54, 0.28 * side, 0.40), (-0.46, 0.46 * side, top)]
        braces = [(-0.05, 0.30 * side, top - 0.05), (-0.54, 0.28 * side, 0.41)]
        feet = [box((0.14, 0.10, 0.02), p[1]) for p in (fore, middle, aft)]
        return join(*(tube(*p, 0.019) for p in (fore, middle, aft)), tube(*braces, 0.011), *feet)

    back = place(revolve([(0.30, 0.10), (0.33, 0.10), (0.335, 0.06)], 32), (0.02, 0, 0))
    rubber = revolve([(0.278, 0.06), (0.284, 0.088), (0.315, 0.09)], 32)
    cross = join(tube((0.345, -0.14, 0), (0.345, 0.14, 0), 0.012))
    cross = join(cross, tube((0.345, 0, -0.14), (0.345, 0, 0.14), 0.012))
    rim = [tube((0.30, 0.145 * c, 0.145 * s), (0.345, 0.14 * c, 0.14 * s), 0.012)
           for c, s in ((1, 0), (-1, 0), (0, 1), (0, -1))]  # fmt: skip
    write(
        "funnel",
        hoops=join(hoops, cross, back, *rim),
        bars=join(*bars),
        stop=rubber,
        struts=both(struts),
        lamps_port=join(*lamps[0]),
        lamps_starboard=join(*lamps[1]),
    )


if __name__ == "__main__":
    main()
