"""Visual meshes of the suspended cradle: `python assets/make_cradle_suspended.py`."""

from shapes import both, box, duct, join, path, place, tube, write

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
    """What models/cradle lacks: heave plates on arms, sleeves and rods."""

    def arms(side):
        return join(*(path([(x, 0.13 * side, 0.182), (x, 0.49 * side, 0.182)], 0.014)
                      for x in (0.72, -0.72)))  # fmt: skip

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

    write(
        "cradle_suspended",
        plates=join(both(heave_plate), both(arms)),
        sleeves=both(sleeves),
        rods=both(rods),
    )


if __name__ == "__main__":
    main()
