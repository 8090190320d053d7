"""Visual meshes of the docks: `python assets/make_docks.py`."""

import numpy as np
import trimesh
from shapes import box, duct, join, path, place, revolve, tube, write

HULL_BOTTOM = -0.3  # z of the carrier's hull bottom, m


def ball(position, radius=0.022):
    """Lamp."""
    return trimesh.creation.icosphere(subdivisions=2, radius=radius).apply_translation(position)


def hoop(x, radius, bar=0.018):
    """Ring about the x axis."""
    ring = trimesh.creation.torus(radius, bar, major_sections=48, minor_sections=10)
    return place(ring, (x, 0, 0), (0, 1, 0), 90)


def both(build):
    """Port and starboard part of `build(side)`."""
    return join(build(1), build(-1))


def funnel() -> None:
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


def pole() -> None:
    """Pole with its sleeve, yoke, ramps, skid, and the struts up to the hull."""
    z, top = 0.114, HULL_BOTTOM + 0.95

    def yoke(side):
        mouth, bend = (-0.80, 0.50 * side, z + 0.035), (-0.27, 0.1166 * side, z + 0.0069)
        return join(
            path([mouth, (-0.14, 0.0225 * side, z)], 0.0115),
            path([(-0.14, 0.0225 * side, z), (0.05, 0.0225 * side, z)], 0.0115),
            path([bend, (-0.75, 0.14 * side, 0.42)], 0.0115),
        )

    def struts(side):
        end = (0.085, 0.58 * side, 0.138)
        mouth = (-0.80, 0.50 * side, z + 0.035)
        over = (-0.80, 0.56 * side, 0.30)
        spar = [(-0.80, 0.56 * side, top - 0.02), (0.09, 0.56 * side, top - 0.02)]
        return join(
            tube(end, (0.085, 0.58 * side, top), 0.024),
            tube((0.085, 0.30 * side, 0.138), (0.085, 0.56 * side, 0.42), 0.014),
            path([mouth, over, (-0.80, 0.56 * side, top)], 0.016),
            tube((-0.75, 0.14 * side, 0.42), (-0.72, 0.56 * side, top - 0.02), 0.014),
            tube((-0.27, 0.1166 * side, z + 0.0069), (-0.20, 0.56 * side, top - 0.02), 0.012),
            tube(*spar, 0.018),
            box((0.14, 0.12, 0.02), (0.09, 0.58 * side, top)),
            box((0.14, 0.12, 0.02), (-0.80, 0.56 * side, top)),
        )

    shaft = tube((0.085, -0.62, 0.138), (0.085, 0.62, 0.138), 0.02, 24)
    clamps = [tube((0.085, y - 0.02, 0.138), (0.085, y + 0.02, 0.138), 0.03, 24)
              for y in (-0.58, -0.3, 0.3, 0.58)]  # fmt: skip
    holder = tube((0.085, 0.0, 0.138), (0.15, 0.0, z + 0.001), 0.010)
    skid = path([(0.13, 0, z + 0.001), (0.60, 0, z + 0.001), (0.72, 0, z + 0.05)], 0.0115)
    stay = tube((0.58, 0, z), (0.30, 0, top), 0.014)
    write(
        "pole",
        pole=join(shaft, *clamps),
        sleeve=tube((0.085, -0.26, 0.138), (0.085, 0.26, 0.138), 0.029, 24),
        yoke=join(both(yoke), skid, holder),
        struts=join(both(struts), stay, box((0.12, 0.10, 0.02), (0.30, 0, top))),
        lamps_port=join(ball((-0.81, 0.508, z + 0.045), 0.02), ball((-0.76, 0.14, 0.43))),
        lamps_starboard=join(ball((-0.81, -0.508, z + 0.045), 0.02), ball((-0.76, -0.14, 0.43))),
    )


def heave_plate(side):
    """Plate 1.7 x 0.28 m with stiffeners and a rounded edge."""
    y, z = 0.32 * side, 0.19
    plate = box((1.66, 0.26, 0.008), (0, y, z))
    corners = [(-0.84, y - 0.13), (0.84, y - 0.13), (0.84, y + 0.13), (-0.84, y + 0.13)]
    rim = path([(*c, z) for c in [*corners, corners[0]]], 0.011)
    ribs = [box((0.012, 0.25, 0.03), (x, y, z + 0.015)) for x in (-0.5, -0.17, 0.17, 0.5)]
    return join(plate, rim, *ribs)


def cradle_suspended() -> None:
    """The bars of models/cradle in a frame with heave plates, sleeves and rods."""

    def forks(side):
        parts = []
        for x in (0.6, -0.6):
            post = [(x, 0.13 * side, 0.2), (x, 0.1273 * side, 0.01), (x, 0.4173 * side, -0.49)]
            brace = [(x, 0.33 * side, 0.18), (x, 0.327 * side, -0.34)]
            parts += [path(post, 0.019), path(brace, 0.012)]
        return join(*parts)

    def flares(side):
        return join(*(path([(x, 0.4173 * side, -0.49), (x, 0.5573 * side, -0.63)], 0.0195)
                      for x in (0.6, -0.6)))  # fmt: skip

    def guides(side):
        parts = []
        for end in (1, -1):
            vee = [(0.0726, 0.1289, 0.2), (0.0726, 0.1289, 0.0993), (0.1933, 0.1289, 0.0)]
            vee.append((0.6, 0.3265, -0.3407))
            parts.append(path([(end * x, side * y, z) for x, y, z in vee], 0.0115))
        slot = place(box((0.10, 0.1016, 0.012)), (0, 0, 0), (1, 0, 0), np.degrees(2.4469) * side)
        return join(*parts, place(slot, (0, 0.0548 * side, 0.1371)))

    def frame(side):
        length = path([(-0.83, 0.13 * side, 0.182), (0.83, 0.13 * side, 0.182)], 0.018)
        arms = [path([(x, 0.13 * side, 0.182), (x, 0.49 * side, 0.182)], 0.014)
                for x in (0.72, -0.72)]  # fmt: skip
        return join(length, *arms)

    def rods(side):
        parts = []
        for x in (0.72, -0.72):
            parts += [
                tube((x, 0.49 * side, HULL_BOTTOM), (x, 0.49 * side, -1.50), 0.014, 20),
                box((0.12, 0.12, 0.02), (x, 0.49 * side, HULL_BOTTOM)),
                tube((x, 0.49 * side, -1.52), (x, 0.49 * side, -1.50), 0.032, 20),
            ]
        return join(*parts, tube((-0.72, 0.49 * side, -0.34), (0.72, 0.49 * side, -0.34), 0.012))

    def sleeves(side):
        turned = (0, 1, 0), 90
        return join(*(place(place(duct(0.034, 0.16, 0.018), (0, 0, 0), *turned),
                            (x, 0.49 * side, 0.182)) for x in (0.72, -0.72)))  # fmt: skip

    ends = [path([(x, -0.13, 0.182), (x, 0.13, 0.182)], 0.018) for x in (0.83, -0.83)]
    holders = [box((0.14, 0.32, 0.02), (x, 0, 0.148)) for x in (0.75, -0.75)]
    pads = [box((0.12, 0.14, 0.04), (x, 0, 0.108)) for x in (0.75, -0.75)]
    lamps = [join(*(ball((x, 0.5643 * s, -0.637), 0.03) for s in (1, -1))) for x in (0.6, -0.6)]
    write(
        "cradle_suspended",
        frame=join(both(frame), both(forks), *ends, *holders),
        guides=both(guides),
        rubber=join(both(flares), *pads),
        plates=both(heave_plate),
        sleeves=both(sleeves),
        rods=both(rods),
        lamps_fore=lamps[0],
        lamps_aft=lamps[1],
    )


def main() -> None:
    funnel()
    pole()
    cradle_suspended()


if __name__ == "__main__":
    main()
