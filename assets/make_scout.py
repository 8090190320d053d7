"""Visual meshes of the Lobster Scout: `python assets/make_scout.py`.

Torpedo hull 1.9 m x 0.2 m with an ellipsoidal nose and a tapered tail (both as published), side
nacelles with the forward thrusters, a recovery fin on top. Shapes are free within those numbers.
"""

import numpy as np
from shapes import box, duct, foil, join, lettering, mirror, path, place, propeller, revolve, write

RADIUS = 0.1  # m
NOSE_START, TAIL_START = 0.70, -0.45  # m, ends of the parallel middle body


def radius_at(x: float) -> float:
    """Hull radius: ellipsoidal nose, parallel middle, tail falling smoothly to 22 mm."""
    if x > NOSE_START:
        s = (x - NOSE_START) / (0.95 - NOSE_START)
        return RADIUS * np.sqrt(max(1 - s**2, 0.0))
    if x < TAIL_START:
        s = (TAIL_START - x) / (0.95 + TAIL_START)
        return 0.022 + (RADIUS - 0.022) * max(1 - s**2, 0.0) ** 1.25
    return RADIUS


def hull_between(aft: float, fore: float, extra: float = 0.0, count: int = 24):
    """Hull surface from `aft` to `fore`, `extra` m proud; closed at both ends."""
    s = 0.5 * (1 - np.cos(np.linspace(0.0, np.pi, count)))
    x = aft + (fore - aft) * s
    return revolve([(xi, max(radius_at(xi) + extra, 1e-4)) for xi in x])


def nacelle():
    """Port side: two foils with a rounded end plate, the guard of two thrusters."""
    span, half_height = 0.305, 0.082
    upper = place(foil(0.12, span, 0.014), (0, 0.085, half_height))
    lower = place(foil(0.12, span, 0.014), (0, 0.085, -half_height))
    middle = place(foil(0.10, span, 0.012), (0, 0.085, 0.0))
    plate = place(foil(0.12, 2 * half_height, 0.012), (0, 0, 0), (1, 0, 0), 90)
    plate = place(plate, (0, 0.394, -half_height))
    return join(upper, lower, middle, plate)


def main() -> None:
    top_fin = place(foil(0.12, 0.085, 0.012, taper=0.85), (0, 0, 0), (1, 0, 0), 90)
    top_fin = place(top_fin, (0, 0, 0.095))
    lug = place(revolve([(-0.005, 0.012), (0.005, 0.012)], 20), (0, 0, 0.155), (0, 0, 1), 90)
    tail_fin = foil(0.14, 0.105, 0.012, taper=0.65)
    tail = join(
        *(
            place(place(tail_fin, (0, 0.03, 0)), (-0.83, 0, 0), (1, 0, 0), angle)
            for angle in (45, 135, 225, 315)
        )
    )
    dome = revolve([(0.880 + 0.072 * s, radius_at(0.880 + 0.07 * s) + 0.001) for s in
                    np.linspace(0.0, 1.0, 10)])  # fmt: skip
    skirt = []
    for x in (0.294, -0.294):
        unit = place(duct(0.040, 0.205, 0.007), (0, 0, 0), (0, 1, 0), -90)
        skirt.append(place(unit, (x, 0.0, 0.0)))
    rings = []
    for x in (0.294, -0.294):
        for side in (90, -90):
            ring = place(duct(0.036, 0.03, 0.008), (0, 0, 0), (0, 0, 1), side)
            rings.append(place(ring, (x, np.copysign(0.080, side), np.copysign(0.05, x))))
    antenna = path([(-0.30, 0, 0.095), (-0.32, 0, 0.155)], 0.006)
    port = place(lettering("LOBSTER", 0.055), (0.55, RADIUS - 0.002, 0.0))
    starboard = place(
        place(lettering("LOBSTER", 0.055), (0, 0, 0), (0, 0, 1), 180), (0.55, -RADIUS + 0.002, 0.0)
    )
    bottom = box((0.13, 0.08, 0.02), (0.06, 0, -0.099))
    side = nacelle()
    write(
        "scout",
        hull=hull_between(-0.95, 0.95, count=72),
        bands=join(
            hull_between(0.215, 0.235, 0.0012, 4),
            hull_between(0.353, 0.373, 0.0012, 4),
            hull_between(-0.373, -0.353, 0.0012, 4),
            hull_between(-0.235, -0.215, 0.0012, 4),
            hull_between(0.715, 0.735, 0.0012, 4),
            hull_between(-0.50, -0.455, 0.0012, 6),
            hull_between(-0.951, -0.90, 0.0012, 6),
        ),
        dome=dome,
        nacelles=join(side, mirror(side)),
        top_fin=join(top_fin, lug),
        tail=tail,
        tunnels=join(*skirt, *rings, bottom, antenna),
        duct=duct(0.043, 0.085, 0.006),
        propeller=propeller(0.036),
        small_propeller=propeller(0.030, blades=4),
        name=join(port, starboard),
    )


if __name__ == "__main__":
    main()
