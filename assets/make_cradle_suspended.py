"""Visual meshes of the suspended cradle: `python assets/make_cradle_suspended.py`."""

import numpy as np
from shapes import ball, both, box, duct, join, path, place, tube, write

HULL_BOTTOM = -0.3  # z of the carrier's hull bottom, m


def heave_plate(side):
    """Plate 1.7 x 0.28 m with stiffeners and a rounded edge."""
    y, z = 0.32 * side, 0.19
    plate = box((1.66, 0.26, 0.008), (0, y, z))
    corners = [(-0.84, y - 0.13), (0.84, y - 0.13), (0.84, y + 0.13), (-0.84, y + 0.13)]
    rim = path([(*c, z) for c in [*corners, corners[0]]], 0.011)
    ribs = [box((0.012, 0.25, 0.03), (x, y, z + 0.015)) for x in (-0.5, -0.17, 0.17, 0.5)]
    return join(plate, rim, *ribs)


def main() -> None:
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


if __name__ == "__main__":
    main()
