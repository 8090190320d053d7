"""Scenarios: everything that defines a run, as validated settings in one TOML file.

Directions are those towards which waves, current and wind travel, in degrees clockwise from
north; positions are NED. Inside the package NWU and radians are used.
"""

from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, model_validator

from marine_mj.errors import ScenarioError
from marine_mj.settings import Settings
from marine_mj.settings_file import SettingsFile

Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
Vector3 = tuple[float, float, float]
Vector6 = tuple[float, float, float, float, float, float]

# Scout limits of the docking reference, digest 3.1 and 3.4, FRD.
_WRENCH_LOW: Vector6 = (-152.0, -68.0, -68.0, -5.0, -20.0, -20.0)
_WRENCH_HIGH: Vector6 = (192.0, 68.0, 68.0, 5.0, 20.0, 20.0)


class Sea(Settings):
    """Waves. Either `sea_state`, or `significant_wave_height` and `peak_period`, or a regular wave.

    Attributes:
        spectrum: "none" for calm water, "regular", or the spectrum of an irregular sea.
        sea_state: 0 to 12, index of the docking reference's table (height and period from it).
        significant_wave_height: H_s, m.
        peak_period: T_p, s.
        peak_enhancement: gamma of JONSWAP.
        height: crest to trough of the regular wave, m.
        period: of the regular wave, s.
        direction_deg: towards which the waves travel, clockwise from north.
        components: number of wave components.
        normals: 2 N standard normals for N components: the sea is `environment.gaussian_sea` of
            them, so that its amplitudes are random too; the seed then draws frequencies and
            directions only. Left out: `irregular_sea`.
        frequency_sampling: "equal_energy": bins that are narrow where the energy is;
            "random_in_bin": equal bins; "midpoint": the docking study's grid, which repeats; left
            out: "equal_energy", for the spectrum "docking_jonswap" "random_in_bin".
        spreading: exponent s of cos^2s directional spreading; left out: long-crested.
        depth: water depth, m, with a sea bed that vehicles touch; left out: deep water.
        stretching: particle motion above the mean level.
    """

    spectrum: Literal[
        "none", "regular", "jonswap", "docking_jonswap", "pierson_moskowitz", "bretschneider"
    ] = "jonswap"
    sea_state: Annotated[int, Field(ge=0, le=12)] | None = None
    significant_wave_height: NotNegative | None = None
    peak_period: Positive | None = None
    peak_enhancement: Annotated[float, Field(ge=1, le=20)] = 3.3
    height: NotNegative | None = None
    period: Positive | None = None
    direction_deg: float = 0.0
    components: Annotated[int, Field(ge=1, le=500)] = 100
    normals: tuple[float, ...] | None = None
    frequency_sampling: Literal["equal_energy", "random_in_bin", "midpoint"] | None = None
    spreading: Positive | None = None
    depth: Positive | None = None
    stretching: Literal["constant", "wheeler", "none"] = "constant"

    @model_validator(mode="after")
    def _one_description(self) -> "Sea":
        """Refuse a sea that is described twice or not at all."""
        spectral = self.significant_wave_height is not None or self.peak_period is not None
        regular = self.height is not None or self.period is not None
        if self.spectrum == "none":
            if spectral or regular or self.sea_state:
                raise ValueError('sea.spectrum = "none" is calm water: leave out all heights')
        elif self.spectrum == "regular":
            if spectral:
                raise ValueError(
                    "a regular wave takes height and period (or sea_state), not "
                    "significant_wave_height and peak_period"
                )
            if self.sea_state is None and (self.height is None or self.period is None):
                raise ValueError("a regular wave needs height and period, or sea_state")
        elif regular:
            raise ValueError('height and period belong to spectrum = "regular"')
        elif self.sea_state is not None and spectral:
            raise ValueError("give sea_state, or significant_wave_height and peak_period, not both")
        elif self.sea_state is None and self.significant_wave_height is None:
            raise ValueError(
                f'spectrum = "{self.spectrum}" needs sea_state (0 to 12), or '
                "significant_wave_height and peak_period"
            )
        return self

    @model_validator(mode="after")
    def _normals_fit(self) -> "Sea":
        """Refuse normals that are not two for each component of an irregular sea."""
        if self.normals is None:
            return self
        if self.spectrum in ("none", "regular"):
            raise ValueError(
                f'normals make an irregular sea, but spectrum = "{self.spectrum}": leave them '
                "out, or take the spectrum of an irregular sea"
            )
        if not all(abs(z) <= 30 for z in self.normals):
            raise ValueError(
                f"normals reach {max(map(abs, self.normals)):g}, allowed are -30 to 30: they are "
                "standard normals"
            )
        if len(self.normals) != 2 * self.components:
            raise ValueError(
                f"normals has {len(self.normals)} numbers, allowed are {2 * self.components}: two "
                f"for each of components = {self.components}"
            )
        return self


class Current(Settings):
    """Water current.

    Attributes:
        speed: at the surface, m/s.
        direction_deg: towards which it flows, clockwise from north.
        profile: "uniform", or "power" (1/7 law, zero at `profile_depth`).
        profile_depth: depth at which the power law ends, m.
        fluctuation: standard deviation of the Gauss-Markov change, m/s.
        time_constant: of the Gauss-Markov change, s.
    """

    speed: NotNegative = 0.0
    direction_deg: float = 0.0
    profile: Literal["uniform", "power"] = "uniform"
    profile_depth: Positive = 50.0
    fluctuation: NotNegative = 0.0
    time_constant: Positive = 300.0


class Wind(Settings):
    """Wind at 10 m height.

    Attributes:
        speed: mean, m/s.
        direction_deg: towards which it blows, clockwise from north.
        gusts: whether to add the gust spectrum.
        height_exponent: a vehicle feels this wind times `(z / 10 m)^height_exponent`, z the height
            of the centroid of its lateral area; 0.12 over open sea (DNV-RP-C205, Table 2-1), 0:
            the same wind at all heights.
    """

    speed: NotNegative = 0.0
    direction_deg: float = 0.0
    gusts: bool = True
    height_exponent: Annotated[float, Field(ge=0, le=1)] = 0.12


class HeadingControl(Settings):
    """Yaw moment `-stiffness psi - damping r` that holds the start heading, within a limit.

    Attributes:
        stiffness: N m/rad.
        damping: N m s/rad.
        limit: largest moment, N m.
    """

    stiffness: Positive
    damping: NotNegative
    limit: Positive


class Vehicle(Settings):
    """One vehicle of the scene.

    Attributes:
        model: name of a vehicle folder, or a path to one.
        position_ned: start of the body origin, m, NED.
        heading_deg: start heading, clockwise from north.
        velocity_frd: start velocity `nu`, m/s and rad/s, body axes FRD.
        motion: "free": by all its forces; "rao": moved by its motion RAOs; "dynamic": by wave
            excitation, restoring and damping from its force RAOs; "fixed": held in space; left
            out: "dynamic" if the model has RAOs, else "free".
        radiation: of a "dynamic" vehicle: "memory" of the water (Cummins' equation), or "constant"
            added mass and damping; left out: "memory" if its wave database has what that needs.
        dock: name of the dock folder that the vehicle carries at its site `dock_mount`.
        dock_stiffness: factor on the stiffness of the dock's contact parts, 1; their damping ratios
            stay.
        actuation: "thrusters" of the model, or an ideal "wrench" at the body origin.
        wrench_low_frd, wrench_high_frd: limits of the ideal wrench, N and N m, FRD.
        planar: keep the vehicle in its vertical plane: north, down and pitch only.
        froude_krylov: pressure force of the undisturbed wave.
        convective: convective part of the water's acceleration.
        strips: wave forces along the length instead of at the origin only.
        constant_buoyancy: full buoyancy even above the surface.
        thrust_loss: thrusters lose thrust with the speed at which they advance through the water.
        drift: second-order wave drift: "none", "mean", or "slow" (mean and slowly varying part);
            left out: "slow" if the model has drift coefficients, is not moved by its RAOs and not
            on panels.
        hydrostatics: "linear": restoring matrix or displaced volume; "panels": water pressure on
            the wetted panels of the model's hull mesh; left out: "panels" where the model has
            nothing but a mesh.
        sheltered_by: vehicle whose floating hull changes the water motion that this one feels below
            it; left out: the waves are undisturbed.
        hull_symmetry: mirror planes of the hull, "xz" (port and starboard), "xz yz" (bow and stern,
            too) or "none", with which a wave database over part of the circle of directions is
            completed; left out: as the file states.
        heading_control: holds the start heading of a vehicle that moves by its forces, as an
            autopilot does; left out: nothing does.
        scale: factors on the vehicle's `mass` (with its inertia), displacement and coefficients by
            name without the frame, e.g. {added_mass = 1.1, strip_drag = 0.9}: the uncertainty of a
            model. Controllers know the vehicle without them.
    """

    model: str
    position_ned: Vector3 = (0.0, 0.0, 0.0)
    heading_deg: float = 0.0
    velocity_frd: Vector6 = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    motion: Literal["free", "rao", "dynamic", "fixed"] | None = None
    radiation: Literal["memory", "constant"] | None = None
    dock: str | None = None
    dock_stiffness: Positive = 1.0
    actuation: Literal["thrusters", "wrench"] = "thrusters"
    wrench_low_frd: Vector6 = _WRENCH_LOW
    wrench_high_frd: Vector6 = _WRENCH_HIGH
    planar: bool = False
    froude_krylov: bool = True
    convective: bool = True
    strips: bool = True
    constant_buoyancy: bool = False
    thrust_loss: bool = False
    drift: Literal["none", "mean", "slow"] | None = None
    hydrostatics: Literal["linear", "panels"] | None = None
    sheltered_by: str | None = None
    excitation: Literal["long_wave", "none"] | None = None
    hull_symmetry: Literal["none", "xz", "xz yz"] | None = None
    heading_control: HeadingControl | None = None
    scale: dict[str, Positive] = Field(default_factory=dict)


class TaskChoice(Settings):
    """What the run is about.

    Attributes:
        domain: module of `marine_mj.tasks`.
        name: task in this domain.
        settings: keyword settings of the task; it validates them itself.
    """

    domain: str
    name: str
    settings: dict[str, Any] = Field(default_factory=dict)


class Scenario(SettingsFile):
    """Everything that defines a run.

    Attributes:
        name: for titles and folders.
        description: one line for lists.
        seed: of all random numbers of the run.
        duration: longest simulated time, s.
        timestep: of the physics, s.
        control_period: between two controller updates, s, a multiple of `timestep`.
        log_period: between two log entries, s, a multiple of `control_period`.
        integrator: of MuJoCo; "auto": RK4 where bodies do not collide, else implicitfast
            (`scene_choices.choose_integrator`).
        contact: whether bodies collide.
        friction_cone: of the contacts; "pyramidal" is replaced by "elliptic" where contact parts
            state a stiffness (docs/docks.md).
        sea, current, wind: the environment.
        water_density: kg/m3.
        vehicles: tables by instance name, in the order in which they are attached.
        task: what is done in this scene.
    """

    kind: ClassVar[str] = "scenario"

    name: str
    description: str = ""
    seed: Annotated[int, Field(ge=0)] = 0
    duration: Positive = 60.0
    timestep: Annotated[float, Field(gt=0, le=0.1)] = 0.005
    control_period: Positive = 0.01
    log_period: Positive = 0.05
    integrator: Literal["auto", "implicitfast", "implicit", "Euler", "RK4"] = "auto"
    contact: bool = True
    friction_cone: Literal["pyramidal", "elliptic"] = "elliptic"
    water_density: Positive = 1025.0
    sea: Sea = Sea(spectrum="none")
    current: Current = Current()
    wind: Wind = Wind()
    vehicles: dict[str, Vehicle] = Field(min_length=1)
    task: TaskChoice

    @model_validator(mode="after")
    def _periods_fit(self) -> "Scenario":
        """Refuse periods that are not whole multiples of each other, and bad instance names."""
        for long, short in (("control_period", "timestep"), ("log_period", "control_period")):
            ratio = getattr(self, long) / getattr(self, short)
            if ratio < 0.999 or abs(ratio - round(ratio)) > 1e-6:
                raise ValueError(
                    f"{long} = {getattr(self, long)} must be a whole multiple of {short} = "
                    f"{getattr(self, short)}"
                )
        for instance in self.vehicles:
            if not instance.isidentifier():
                raise ValueError(
                    f"vehicle name {instance!r} is not allowed: letters, digits and _ only"
                )
        for instance, vehicle in self.vehicles.items():
            others = [name for name in self.vehicles if name != instance]
            if vehicle.sheltered_by is not None and vehicle.sheltered_by not in others:
                raise ValueError(
                    f"vehicles.{instance}.sheltered_by is {vehicle.sheltered_by!r}; allowed is "
                    f"another vehicle of the scenario: {', '.join(others) or 'there is none'}"
                )
        return self

    @model_validator(mode="after")
    def _above_the_bed(self) -> "Scenario":
        """Refuse a start below the sea bed."""
        depth = self.sea.depth
        for instance, vehicle in self.vehicles.items():
            if depth is not None and vehicle.position_ned[2] >= depth:
                raise ValueError(
                    f"vehicles.{instance}.position_ned starts "
                    f"{vehicle.position_ned[2]:g} m deep, below the sea bed at sea.depth = "
                    f"{depth:g} m: start it higher, or take deeper water"
                )
        return self

    @property
    def nominal(self) -> "Scenario":
        """The scenario as controllers know it: without the factors of `Vehicle.scale`."""
        changes: dict[str, Any] = {
            f"vehicles.{name}.scale": {} for name, v in self.vehicles.items() if v.scale
        }
        return self.with_values(changes) if changes else self

    def with_values(self, changes: dict[str, Any]) -> "Scenario":
        """A validated copy with values replaced by dotted keys, such as `sea.sea_state`."""
        values = self.model_dump()
        for key, value in changes.items():
            *path, last = key.split(".")
            table = values
            for part in path:
                table = table.setdefault(part, {})
                if not isinstance(table, dict):
                    raise ScenarioError(f"{key}: {part!r} is a value, not a table")
            table[last] = value
        return self.parse(values, f"scenario {self.name}")
