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
    mouth, throat, end = (-0.50, 0.434), (0.0, 0.132), (0.30, 0.132)
    bars, sleeves, lamps = [], [], ([], [])
    for i in range(16):
        angle = 2 * np.pi * (i + 0.5) / 16
        c, s = np.cos(angle), np.sin(angle)
        points = [(x, r * c, r * s) for x, r in (mouth, throat, end)]
        bars.append(path(points[:2], 0.0135))
        sleeves.append(tube(*points[1:], 0.0235))
        if i % 2 == 0:
            lamps[int(c < 0)].append(ball((-0.512, 0.45 * c, 0.45 * s), 0.026))
    hoops = join(
        hoop(-0.50, 0.454, 0.02),
        hoop(-0.25, 0.303, 0.014),
        hoop(0.0, 0.165, 0.016),
        hoop(0.15, 0.165, 0.014),
        hoop(0.30, 0.165, 0.016),
    )
    top = HULL_BOTTOM + 1.05

    def struts(side):
        fore = [(0.28, 0.03 * side, 0.165), (0.42, 0.16 * side, top)]
        middle = [(0.0, 0.06 * side, 0.155), (-0.05, 0.30 * side, top)]
        aft = [(-0.49, 0.26 * side, 0.373), (-0.46, 0.46 * side, top)]
        braces = [(-0.05, 0.30 * side, top - 0.05), (-0.49, 0.26 * side, 0.383)]
        feet = [box((0.14, 0.10, 0.02), p[1]) for p in (fore, middle, aft)]
        return join(*(tube(*p, 0.019) for p in (fore, middle, aft)), tube(*braces, 0.011), *feet)

    back = place(revolve([(0.30, 0.10), (0.33, 0.10), (0.335, 0.06)], 32), (0.02, 0, 0))
    rubber = revolve([(0.278, 0.06), (0.284, 0.088), (0.315, 0.09)], 32)
    cross = join(tube((0.345, -0.16, 0), (0.345, 0.16, 0), 0.012))
    cross = join(cross, tube((0.345, 0, -0.16), (0.345, 0, 0.16), 0.012))
    rim = [tube((0.30, 0.165 * c, 0.165 * s), (0.345, 0.16 * c, 0.16 * s), 0.012)
           for c, s in ((1, 0), (-1, 0), (0, 1), (0, -1))]  # fmt: skip
    write(
        "funnel",
        hoops=join(hoops, cross, back, *rim),
        bars=join(*bars),
        stop=join(rubber, *sleeves),
        struts=both(struts),
        lamps_port=join(*lamps[0]),
        lamps_starboard=join(*lamps[1]),
    )


if __name__ == "__main__":
    main()
