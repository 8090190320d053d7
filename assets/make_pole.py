"""Visual meshes of the horizontal pole: `python assets/make_pole.py`."""

from shapes import ball, both, box, join, path, tube, write

HULL_BOTTOM = -0.3  # z of the carrier's hull bottom, m


def main() -> None:
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


if __name__ == "__main__":
    main()
