"""Visual meshes of the BlueROV2 (heavy, 8 thrusters): `python assets/make_bluerov2.py`.

Overall 0.457 x 0.575 x 0.254 m (public data sheet); origin at the centre of buoyancy.
"""

import numpy as np
from shapes import (
    box,
    duct,
    grid_surface,
    join,
    mirror,
    path,
    place,
    propeller,
    revolve,
    tube,
    write,
)


def pillow(size, position, power: float = 5.0):
    """Box of full edge lengths `size` with round edges (a superellipsoid loft along x)."""
    length, width, height = size
    angle = np.linspace(0, 2 * np.pi, 28, endpoint=False)
    y = np.sign(np.cos(angle)) * np.abs(np.cos(angle)) ** (2 / power) * width / 2
    z = np.sign(np.sin(angle)) * np.abs(np.sin(angle)) ** (2 / power) * height / 2
    rings = []
    for s in np.sin(np.linspace(-np.pi / 2, np.pi / 2, 14)):
        scale = max(1 - abs(s) ** 8, 0.0) ** 0.35
        scale = 0.86 + 0.14 * scale if abs(s) < 1 else 0.82
        rings.append(np.column_stack([np.full(28, s * length / 2), y * scale, z * scale]))
    return place(grid_surface(rings), position)


def side_panel():
    """Port frame plate: bars around two openings, feet below."""
    y, t = 0.163, 0.012
    return join(
        pillow((0.44, t, 0.045), (0.0, y, 0.055)),
        pillow((0.44, t, 0.040), (0.0, y, -0.100)),
        pillow((0.055, t, 0.20), (0.19, y, -0.025)),
        pillow((0.055, t, 0.20), (-0.19, y, -0.025)),
        pillow((0.075, t, 0.17), (0.0, y, -0.02)),
        pillow((0.10, 0.03, 0.022), (0.15, y, -0.118)),
        pillow((0.10, 0.03, 0.022), (-0.15, y, -0.118)),
    )


def main() -> None:
    panel = side_panel()
    foam = join(
        pillow((0.215, 0.105, 0.075), (0.113, 0.10, 0.088)),
        pillow((0.215, 0.105, 0.075), (-0.113, 0.10, 0.088)),
        pillow((0.17, 0.075, 0.045), (0.0, 0.225, 0.075)),
    )
    outrigger = join(
        box((0.30, 0.10, 0.010), (0, 0.205, 0.045)),
        *(tube((x, 0.165, 0.03), (x, 0.218, 0.03), 0.010) for x in (0.12, -0.12)),
    )
    corner = [tube((sx * 0.156, 0.111, -0.05), (sx * 0.156, 0.111, -0.02), 0.014) for sx in (1, -1)]
    cross = join(*(box((0.03, 0.32, 0.012), (x, 0, -0.085)) for x in (0.12, 0.0, -0.12)))
    frame = join(outrigger, mirror(outrigger), cross, *corner, *(mirror(c) for c in corner))
    bottle = join(
        revolve([(-0.165, 0.058), (-0.16, 0.062), (0.115, 0.062), (0.12, 0.058)], 40),
        place(
            revolve([(-0.13, 0.045), (-0.125, 0.050), (0.125, 0.050), (0.13, 0.045)], 32),
            (-0.01, 0, -0.095),
        ),
    )
    bottle = place(bottle, (0, 0, 0.02))
    s = np.linspace(0.0, np.pi / 2, 12)
    dome = revolve(np.column_stack([0.12 + 0.055 * np.sin(s), 0.0555 * np.cos(s) + 1e-4]), 40)
    camera = join(
        box((0.03, 0.05, 0.045), (0.115, 0, 0.0)), tube((0.12, 0, 0), (0.15, 0, 0), 0.014)
    )
    lamp = revolve([(-0.03, 0.014), (0.0, 0.019), (0.022, 0.019), (0.024, 0.016)], 20)
    lights = join(*(place(lamp, (0.20, y, z)) for y in (0.125, -0.125) for z in (-0.055, 0.01)))
    swing = np.linspace(0, 1, 12)
    tether = np.column_stack(
        [-0.165 - 0.30 * swing, 0.03 * np.sin(3 * swing), 0.03 + 0.25 * swing**2]
    )
    write(
        "bluerov2",
        panels=join(panel, mirror(panel)),
        foam=join(foam, mirror(foam)),
        frame=frame,
        bottles=bottle,
        dome=place(dome, (0, 0, 0.02)),
        camera=place(camera, (0, 0, 0.02)),
        lights=lights,
        tether=path(tether, 0.0045, 8),
        duct=duct(0.0485, 0.065, 0.007),
        propeller=propeller(0.038),
    )


if __name__ == "__main__":
    main()
