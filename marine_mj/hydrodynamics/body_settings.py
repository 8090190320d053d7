"""How a body is simulated: the choices of a model, and what follows from them for a body."""

from dataclasses import dataclass
from typing import Literal, get_args

from marine_mj.errors import ModelError
from marine_mj.hydrodynamics.coefficients import BodyCoefficients
from marine_mj.hydrodynamics.drift import Drift
from marine_mj.hydrodynamics.memory import Memory
from marine_mj.hydrodynamics.memory_store import database_memory, has_memory_data
from marine_mj.hydrodynamics.wave_file import HullSymmetry

Motion = Literal["free", "dynamic", "rao", "fixed"]
Radiation = Literal["memory", "constant"]
Hydrostatics = Literal["linear", "panels"]
Excitation = Literal["long_wave", "none"]


@dataclass(frozen=True)
class BodySettings:
    """How a body is simulated; the defaults are the complete physics.

    Attributes:
        motion: "dynamic" (wave forces from force RAOs), "rao" (plays back motion RAOs whatever
            touches it), "fixed" (held in space, whatever touches it), "free" (no RAO table); None:
            "dynamic" with a wave database, else "free".
        radiation: of a "dynamic" body: "memory" (Cummins' equation with A(inf) and states for
            the memory of the water), or "constant" added mass and damping chosen for the sea;
            None: "memory" where the wave database has A(inf), else "constant".
        strips: False reduces a slender body to one point with its lumped damping.
        froude_krylov: undisturbed wave pressure on the displaced volume.
        convective: material acceleration of the water; False: its local time derivative.
        constant_buoyancy: buoyancy does not change at the surface, nor anything else that the wet
            share of a body changes.
        thrust_loss: thrusters lose thrust with the speed at which they advance (for those whose
            model says how much).
        drift: second-order wave drift, "mean" or "slow" (mean and slowly varying part); None:
            "slow" where the body has coefficients for it (`hydrodynamics.drift`) and is not on
            panels, else "none".
        hydrostatics: "linear" (restoring matrix, or displaced volume), "panels" (pressure of still
            water and incident waves on the wetted panels of the hull mesh, instead of both and of
            the Froude-Krylov part of force RAOs); None: "panels" for a body that has a hull mesh
            and neither restoring nor volume, else "linear".
        sheltered_by: name of a floating body with a shelter database, whose hull changes the water
            motion that this body feels (`hydrodynamics.shelter`); None: undisturbed waves.
        excitation: of a "free" body with a restoring matrix: "long_wave" (it rides on the waves as
            on long ones, `hydrodynamics.excitation`), "none" (it floats in still water, and feels
            no more than the water's motion at its origin); None: "long_wave" where the matrix has
            a waterplane (G33 > 0).
        hull_symmetry: mirror planes of the hull through the body origin, with which a wave database
            over part of the circle of directions is completed: "xz" (port and starboard), "xz yz"
            (bow and stern, too), "none"; None: as the file states (its attribute hull_symmetry).
    """

    motion: Motion | None = None
    strips: bool = True
    froude_krylov: bool = True
    convective: bool = True
    constant_buoyancy: bool = False
    thrust_loss: bool = False
    drift: Drift | None = None
    radiation: Radiation | None = None
    hydrostatics: Hydrostatics | None = None
    sheltered_by: str | None = None
    excitation: Excitation | None = None
    hull_symmetry: HullSymmetry | None = None

    def __post_init__(self) -> None:
        """Check the choices."""
        for name, kinds in (
            ("motion", Motion),
            ("drift", Drift),
            ("radiation", Radiation),
            ("hydrostatics", Hydrostatics),
            ("excitation", Excitation),
            ("hull_symmetry", HullSymmetry),
        ):
            value = getattr(self, name)
            if value is not None and value not in get_args(kinds):
                raise ModelError(f"{name} is {value!r}, allowed are {', '.join(get_args(kinds))}")
        if self.hydrostatics == "panels" and self.constant_buoyancy:
            raise ModelError(
                'constant_buoyancy is True with hydrostatics "panels", allowed is False: panels '
                "lose their buoyancy above the surface; leave out one of them"
            )


def motion_of(body: BodyCoefficients, settings: BodySettings) -> Motion:
    """The motion a body gets; see `BodySettings.motion`.

    Raises:
        ModelError: RAOs are asked for and the body names no wave database.
    """
    motion = settings.motion or ("dynamic" if body.wave_database else "free")
    if motion not in ("free", "fixed") and body.wave_database is None:
        raise ModelError(
            f"motion {motion!r} of {body.name!r} needs RAOs; allowed are 'free' and 'fixed', or a "
            f'database: <text name="{body.name}.wave_database" data="FILE.nc"/>'
        )
    return motion


def memory_of(body: BodyCoefficients, settings: BodySettings) -> Memory | None:
    """The radiation memory a body is simulated with; see `BodySettings.radiation`.

    Raises:
        ModelError: memory is asked for and the body is not "dynamic", or its wave database lacks
            what it needs or cannot be fitted.
    """
    motion = motion_of(body, settings)
    if motion != "dynamic":
        if settings.radiation == "memory":
            raise ModelError(
                f"radiation 'memory' of {body.name!r} needs the motion 'dynamic', it is "
                f"{motion!r}: leave radiation out"
            )
        return None
    name = str(body.wave_database)
    if settings.radiation == "constant" or (
        settings.radiation is None and not has_memory_data(name)
    ):
        return None
    return database_memory(name)
