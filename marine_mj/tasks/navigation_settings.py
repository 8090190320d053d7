"""Settings of navigation, as they stand under `[task.settings.navigation]` of a scenario."""

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, model_validator

from marine_mj.controllers.navigation import (
    PLANAR_SCENARIOS,
    Camera,
    CarrierNavigation,
    Compass,
    Dvl,
    GaussMarkov,
    Gnss,
    Imu,
    InertialNavigation,
    Navigator,
    PerfectNavigation,
    PlanarNavigation,
    PlanarNoise,
    Pressure,
    Timing,
    Usbl,
    planar_scenario,
)
from marine_mj.frames import Array
from marine_mj.settings import Settings

Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
Share = Annotated[float, Field(ge=0, le=1)]
Vector3 = tuple[float, float, float]
Vector6 = tuple[float, float, float, float, float, float]


class Sampling(Settings):
    """When a sensor samples.

    Attributes:
        enabled: whether it is there.
        period: between two samples, s.
        delay: from a sample to its arrival, s, shorter than `period`.
        dropout: share of the samples that are lost.
    """

    enabled: bool = True
    period: Positive = 0.1
    delay: NotNegative = 0.0
    dropout: Share = 0.0

    def timing(self, update: float) -> Timing:
        """Timing in updates of `update` s."""
        return Timing.of(self.period, self.delay, self.dropout, update)


class PromptSampling(Settings):
    """When a sensor without delay samples; see `Sampling`."""

    enabled: bool = True
    period: Positive = 0.1
    dropout: Share = 0.0

    def timing(self, update: float) -> Timing:
        """Timing in updates of `update` s."""
        return Timing.of(self.period, 0.0, self.dropout, update)


class ImuSettings(Settings):
    """Changes of `controllers.navigation.Imu`, for vehicle and carrier."""

    accelerometer: NotNegative = float(np.sqrt(0.02))
    gyro: NotNegative = 0.004
    accelerometer_bias: NotNegative = 0.02
    gyro_bias: NotNegative = 5e-4
    bias_time: Positive = 600.0

    def imu(self) -> Imu:
        """The sensor."""
        return Imu(
            self.accelerometer,
            self.gyro,
            GaussMarkov(self.accelerometer_bias, self.bias_time),
            GaussMarkov(self.gyro_bias, self.bias_time),
        )


class DvlSettings(PromptSampling):
    """Changes of `controllers.navigation.Dvl`; `seabed` is the depth of the sea bed, m."""

    seabed: Positive = 20.0
    highest: Positive = 50.0
    floor: NotNegative = 0.00084
    slope: NotNegative = 0.038


class PressureSettings(PromptSampling):
    """Changes of `controllers.navigation.Pressure`."""

    deviation: Positive = 0.05


class CompassSettings(PromptSampling):
    """Changes of `controllers.navigation.Compass`."""

    deviation_deg: Positive = 1.0


class UsblSettings(Sampling):
    """Changes of `controllers.navigation.Usbl`."""

    period: Positive = 1.0
    delay: NotNegative = 0.2


class CameraSettings(Sampling):
    """Changes of `controllers.navigation.Camera`; the marker is above the seat of the dock.

    Attributes:
        half_angle_deg: of the field of view.
        reach: largest distance, m.
        marker_height: of the marker above the vehicle's origin when docked, m.
        occluders: boxes that may hide the marker: corners (2, 3) in the carrier's axes FLU, m.
    """

    delay: NotNegative = 0.08
    half_angle_deg: Annotated[float, Field(gt=0, le=90)] = 45.0
    reach: Positive = 8.0
    marker_height: float = 0.3
    occluders: tuple[tuple[Vector3, Vector3], ...] = ()


class GnssSettings(PromptSampling):
    """Changes of `controllers.navigation.Gnss`."""

    period: Positive = 0.2
    bias: NotNegative = 0.5
    bias_time: Positive = 300.0


class LinkSettings(Sampling):
    """The acoustic link from carrier to vehicle.

    Attributes:
        wave_frequency: with which the carrier's motion is continued from the last message, rad/s;
            0: constant acceleration.
    """

    period: Positive = 0.2
    delay: NotNegative = 0.1
    wave_frequency: NotNegative = 1.25


class NavigationSettings(Settings):
    """What the controllers know of the vehicles.

    Attributes:
        kind: "perfect": everything; "thesis": the docking study's measurement model and filters,
            for planar vehicles; "inertial": sensors and error-state filters in three dimensions.
        scenario: of "thesis", see `controllers.navigation.PLANAR_SCENARIOS`.
        fix_period: of "thesis", instead of the scenario's, s.
        acceleration: of "thesis", standard deviations of the rates of u, w, q.
        fix: of "thesis", standard deviations of x, z, theta, u, w, q.
        imu, dvl, pressure, compass, usbl, camera, gnss, link: of "inertial".
    """

    kind: Literal["perfect", "thesis", "inertial"] = "perfect"
    scenario: str = "base"
    fix_period: Positive | None = None
    acceleration: tuple[NotNegative, NotNegative, NotNegative] | None = None
    fix: tuple[Positive, Positive, Positive, Positive, Positive, Positive] | None = None
    imu: ImuSettings = ImuSettings()
    dvl: DvlSettings = DvlSettings()
    pressure: PressureSettings = PressureSettings()
    compass: CompassSettings = CompassSettings()
    usbl: UsblSettings = UsblSettings()
    camera: CameraSettings = CameraSettings()
    gnss: GnssSettings = GnssSettings()
    link: LinkSettings = LinkSettings()

    @model_validator(mode="after")
    def _settings_of_the_kind(self) -> "NavigationSettings":
        """Refuse settings of another kind, a scenario that does not exist, a missing link."""
        thesis = {"scenario", "fix_period", "acceleration", "fix"}
        inertial = set(type(self).model_fields) - thesis - {"kind"}
        foreign = {"perfect": thesis | inertial, "thesis": inertial, "inertial": thesis}[self.kind]
        default = type(self).model_fields
        wrong = [k for k in sorted(foreign) if getattr(self, k) != default[k].default]
        if wrong:
            raise ValueError(f"kind = {self.kind!r} has no {', '.join(wrong)}: leave it out")
        if self.scenario not in PLANAR_SCENARIOS:
            raise ValueError(
                f"scenario = {self.scenario!r} does not exist; available: "
                f"{', '.join(PLANAR_SCENARIOS)}"
            )
        for name in ("gnss", "link"):
            if not getattr(self, name).enabled:
                raise ValueError(f"{name}.enabled = false: the carrier would not be known")
        return self

    def navigator(self, update: float, gravity: float, seat: Array) -> Navigator:
        """The navigator.

        Args:
            update: time between two updates, s.
            gravity: m/s2.
            seat: (3,) origin of the docked vehicle in the carrier's axes FLU, m.

        Raises:
            ScenarioError: a period or delay is not a whole number of updates.
        """
        if self.kind == "perfect":
            return PerfectNavigation()
        if self.kind == "thesis":
            base = planar_scenario(self.scenario)
            noise = PlanarNoise(
                self.fix_period or base.fix_period,
                base.acceleration if self.acceleration is None else self.acceleration,
                base.fix if self.fix is None else self.fix,
            )
            return PlanarNavigation.of(noise, update)
        return self._inertial(update, gravity, seat)

    def _inertial(self, update: float, gravity: float, seat: Array) -> InertialNavigation:
        """Navigation with individual sensors."""
        imu, bias = self.imu.imu(), GaussMarkov(self.gnss.bias, self.gnss.bias_time)
        carrier = CarrierNavigation(
            update,
            self.link.timing(update),
            Gnss(self.gnss.timing(update), bias),
            imu,
            gravity,
            frequency=self.link.wave_frequency,
        )
        return InertialNavigation(
            update,
            carrier,
            imu=imu,
            gravity=gravity,
            position_error=GaussMarkov(max(self.gnss.bias, 0.05), self.gnss.bias_time),
            **self._sensors(update, seat),
        )

    def _sensors(self, update: float, seat: Array) -> dict[str, Any]:
        """Sensors of the vehicle that are there."""
        dvl, camera = self.dvl, self.camera
        marker = np.asarray(seat, dtype=float) + np.array([0.0, 0.0, camera.marker_height])
        boxes = np.reshape(np.array(camera.occluders, dtype=float), (-1, 2, 3))
        half = float(np.deg2rad(camera.half_angle_deg))
        made = {
            "dvl": lambda t: Dvl(
                t, floor=dvl.floor, slope=dvl.slope, seabed=dvl.seabed, highest=dvl.highest
            ),
            "pressure": lambda t: Pressure(t, self.pressure.deviation),
            "compass": lambda t: Compass(t, float(np.deg2rad(self.compass.deviation_deg))),
            "usbl": lambda t: Usbl(t),
            "camera": lambda t: Camera(
                t, marker=marker, half_angle=half, reach=camera.reach, boxes=boxes
            ),
        }
        return {
            name: make(getattr(self, name).timing(update))
            for name, make in made.items()
            if getattr(self, name).enabled
        }
