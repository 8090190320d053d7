"""What to compute for a hull, and what of it is allowed."""

from dataclasses import dataclass

import numpy as np

from marine_mj.errors import ModelError


@dataclass(frozen=True)
class Settings:
    """What to compute for a hull; SI units, radians, body axes FLU.

    Attributes:
        scale: metres per unit of the mesh file.
        waterline: height of the still water in the mesh, m; default 0, for a vehicle minus its
            `equilibrium_height`.
        draught: instead of `waterline`: depth of the lowest point, m.
        mass: kg; default the displaced mass, for a vehicle that of its bodies.
        center_of_mass: in mesh coordinates, m; see `rigid_body` for what is assumed.
        inertia, gyration: diagonal about the centre of mass, kg m2, or radii of gyration, m.
        density, gravity, depth: kg/m3, m/s2, m.
        omega, directions: rad/s, rad; None: from the hull's length; every 15 degrees, or
            as many as its shortest waves need.
        panel: wanted panel size, m; None: about 700 panels.
        symmetry: solve for half or a quarter of a hull with mirror planes.
        lid: panels in the waterplane against irregular frequencies.
        submerged: True: unbounded fluid; False: waves; None: waves where the hull reaches the
            surface.
        method: boundary integral equation, see `solve`.
        drift: add the mean wave drift of the far field; takes the indirect method.
        shelter: keep what `shelter_of` needs; takes the indirect method.
        repair: see `read_mesh`.
        roll_damping, pitch_damping: viscous shares of critical damping.
        viscous: (6, 6) viscous damping matrix, flattened or diagonal, N s/m ... N m s.
        quadratic: (6,) quadratic damping for the RAOs at `amplitude`, see `drag_motion_raos`.
        amplitude: of the waves for `quadratic`, m.
    """

    scale: float = 1.0
    waterline: float | None = None
    draught: float | None = None
    mass: float | None = None
    center_of_mass: tuple[float, ...] | None = None
    inertia: tuple[float, ...] | None = None
    gyration: tuple[float, ...] | None = None
    density: float = 1025.0
    gravity: float = 9.81
    depth: float = float("inf")
    omega: tuple[float, ...] | None = None
    directions: tuple[float, ...] | None = None
    panel: float | None = None
    symmetry: bool = True
    lid: bool = True
    submerged: bool | None = None
    method: str = "direct"
    drift: bool = False
    shelter: bool = False
    repair: bool = False
    roll_damping: float = 0.0
    pitch_damping: float = 0.0
    viscous: tuple[float, ...] | None = None
    quadratic: tuple[float, ...] | None = None
    amplitude: float = 1.0

    @property
    def needs_sources(self) -> bool:
        """Whether the sources on the panels are used, which only the indirect method has."""
        return self.drift or self.shelter


def check_settings(s: Settings) -> None:
    """Raise for settings that are not allowed.

    Raises:
        ModelError: the message names the setting.
    """
    if s.waterline is not None and s.draught is not None:
        raise ModelError("both waterline and draught are given, allowed is one of them")
    for name in ("draught", "density", "gravity", "depth", "panel", "amplitude"):
        value = getattr(s, name)
        if value is not None and not value > 0:
            raise ModelError(f"{name} is {value:g}; allowed is a number above 0")
    for name, sizes in (("viscous", (6, 36)), ("quadratic", (6,))):
        values = getattr(s, name)
        if values is not None and len(values) not in sizes:
            raise ModelError(
                f"{name} has {len(values)} values; allowed are {' or '.join(map(str, sizes))}"
            )
    for name in ("center_of_mass", "inertia", "gyration"):
        values = getattr(s, name)
        if values is not None and not (len(values) == 3 and np.isfinite(values).all()):
            raise ModelError(f"{name} is {list(values)}; allowed are 3 finite numbers (x y z)")
    for name in ("omega", "directions"):
        values = getattr(s, name)
        if values is not None and (len(values) == 0 or not np.isfinite(values).all()):
            raise ModelError(f"{name} is {values}; allowed are one or more finite numbers")
    if s.omega is not None and (min(s.omega) <= 0 or len(set(s.omega)) < max(len(s.omega), 2)):
        raise ModelError(
            f"omega is {s.omega}; allowed are two or more different frequencies above 0 rad/s"
        )
