"""Visual meshes of the horizontal pole: `python assets/make_pole.py`."""

from shapes import ball, both, box, join, path, tube, write

TOP = -0.3 + 1.1  # the carrier's hull bottom from the seat, m
MOUTH, ENTRY, END = -0.95, -0.3, 0.7  # x of tips, of the rails' aft ends and of their fore ends
POLE, FIN = 0.085, 0.15  # x of the pole; height of pole, yoke and notch


def rail(side, way):
    """One sleeve: ramp and rail, `way` 1 above the hull and -1 below it."""
    y, z = 0.075 * side, 0.1062 * way
    return path([(MOUTH, 0.11 * side, 0.42 * way), (ENTRY, y, z), (END, y, z)], 0.0215, 10)


def yoke(side):
    """Guide of the fin, standing on an upper rail."""
    notch = [(-0.14, 0.0215 * side, FIN), (0.05, 0.0215 * side, FIN)]
    aft = path([(ENTRY, 0.075 * side, 0.1062), (ENTRY, 0.07 * side, FIN), notch[0]], 0.0115)
    return join(aft, path([*notch, (POLE, 0.0215 * side, FIN)], 0.0115))


def struts(side):
    """What carries rails and pole: outside the nacelles, which reach to y = 0.4 m."""
    parts = []
    for x, y, z in ((MOUTH, 0.11, 0.42), (ENTRY, 0.075, 0.1062), (END, 0.075, 0.1062)):
        low = -z - 0.08
        beam = [(x, y, -z), (x, y + 0.05, low), (x, 0.52, low), (x, 0.58, low + 0.06)]
        parts += [
            path([(x, a * side, h) for a, h in [p[1:] for p in beam] + [(0.58, TOP)]], 0.016),
            tube((x, y * side, z), (x, 0.28 * side, TOP), 0.014),
            box((0.12, 0.12, 0.02), (x, 0.58 * side, TOP)),
            box((0.10, 0.10, 0.02), (x, 0.28 * side, TOP)),
        ]
    return join(
        *parts,
        tube((POLE, 0.58 * side, FIN), (POLE, 0.58 * side, TOP), 0.022),
        tube((POLE, 0.30 * side, FIN), (POLE, 0.57 * side, FIN + 0.28), 0.014),
        box((0.14, 0.12, 0.02), (POLE, 0.58 * side, TOP)),
        tube((MOUTH, 0.58 * side, 0.0), (ENTRY, 0.58 * side, 0.0), 0.012),
        tube((ENTRY, 0.58 * side, 0.0), (END, 0.58 * side, 0.0), 0.012),
    )


def main() -> None:
    """Pole with its sleeve, rails, yoke, and the struts up to the hull."""
    shaft = tube((POLE, -0.62, FIN), (POLE, 0.62, FIN), 0.02, 24)
    clamps = [tube((POLE, y - 0.02, FIN), (POLE, y + 0.02, FIN), 0.03, 24)
              for y in (-0.58, -0.3, 0.3, 0.58)]  # fmt: skip
    lamps = [join(*(ball((MOUTH - 0.012, 0.11 * side, z), 0.03) for z in (0.426, -0.426)))
             for side in (1, -1)]  # fmt: skip
    write(
        "pole",
        pole=join(shaft, *clamps),
        sleeve=tube((POLE, -0.26, FIN), (POLE, 0.26, FIN), 0.029, 24),
        rails=join(*(rail(side, way) for side in (1, -1) for way in (1, -1))),
        yoke=both(yoke),
        struts=both(struts),
        lamps_port=lamps[0],
        lamps_starboard=lamps[1],
    )


if __name__ == "__main__":
    main()
