"""Linear wave field: elevation and water kinematics of a frozen sum of wave components."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from marine_mj.environment._checks import Frozen, array, number, one_of
from marine_mj.environment.dispersion import wavenumber
from marine_mj.errors import SeaError
from marine_mj.frames import Array

Stretching = Literal["constant", "wheeler", "none"]

#: Entries of one (points, components) work array: 1 MB, so that it stays in the cache.
_BLOCK = 2**17
#: Share of its depth that the water keeps in Wheeler's stretching where a trough reaches the bed.
LEAST_WATER = 1e-3


@dataclass(frozen=True, eq=False)
class WaveField(Frozen):
    """Sum of N linear waves in water of constant depth; world NWU, z up from still water.

    `zeta = sum a cos(theta)`, `theta = k (x cos b + y sin b) - omega t + phase`, that is
    `Re(Z exp(-i omega t))` with the phasors `Z` of `phasors`. The potential (Newman 1977, ch. 6)
    is `phi = sum (a g / omega) C(z) sin(theta)`, with `C = cosh(k (z + h)) / cosh(k h)`, in deep
    water `exp(k z)`; velocity is its gradient.

    Above still water the linear theory says nothing; `stretching` chooses the height z' at which
    depth functions are taken. Whether a point is wet is not asked: compare z with `elevation`.
    Points below the bed count as at the bed.

    - "constant": `z' = min(z, 0)`.
    - "wheeler": `z' = (z - zeta) / (1 + zeta / h)`, never above 0 (Wheeler 1970); the divisor is
      at least 0.001 where a trough reaches the bed.
    - "none": `z' = z`, exponential growth above still water included.

    `pressure - rho g z` vanishes at the free surface with "wheeler", and at crests with
    "constant". Derivatives are taken at constant z' (the linear field, looked up at z').

    Attributes:
        omega: (N,) angular frequencies, rad/s, > 0.
        wavenumber: (N,) k, rad/m; has to obey `omega^2 = g k tanh(k h)`.
        direction: (N,) direction of travel b, rad, NWU: counter-clockwise from north (x).
        amplitude: (N,) a, m, >= 0.
        phase: (N,) rad.
        depth: water depth h, m; inf for deep water.
        gravity: g, m/s2.
        stretching: "constant", "wheeler" or "none".

    Raises:
        SeaError: an array or value is out of range, or k does not obey the dispersion relation.
    """

    omega: Array
    wavenumber: Array
    direction: Array
    amplitude: Array
    phase: Array
    depth: float = np.inf
    gravity: float = 9.81
    stretching: Stretching = "constant"

    def __post_init__(self) -> None:
        """Check and freeze."""
        size: tuple[int | str, ...] = ("N",)
        units = {"omega": "rad/s", "wavenumber": "rad/m", "direction": "rad"}
        for name, unit in (units | {"amplitude": "m", "phase": "rad"}).items():
            value = array(name, getattr(self, name), size, unit)
            object.__setattr__(self, name, value)
            size = value.shape
        fix = "give the water depth, inf for deep water"
        depth = number("depth", self.depth, "m", fix, above=0, infinite=True)
        gravity = number("gravity", self.gravity, "m/s2", "9.81 on Earth", above=0)
        object.__setattr__(self, "depth", depth)
        object.__setattr__(self, "gravity", gravity)
        one_of("stretching", self.stretching, get_args(Stretching))
        if (self.amplitude < 0).any():
            raise SeaError(
                f"amplitude has the value {self.amplitude.min():g} m, allowed is >= 0: "
                "turn the wave over by adding pi to its phase"
            )
        expected = wavenumber(self.omega, depth, gravity)
        wrong = np.abs(self.wavenumber - expected) > 1e-6 * expected
        if wrong.any():
            i = int(np.argmax(wrong))
            raise SeaError(
                f"wavenumber[{i}] is {self.wavenumber[i]:g} rad/m, allowed is {expected[i]:g} at "
                f"{self.omega[i]:g} rad/s and depth {depth:g} m: use wavenumber(omega, depth)"
            )

    @property
    def significant_height(self) -> float:
        """`4 sqrt(m0)` [m] of this realisation, `m0 = sum a^2 / 2`."""
        return float(4 * np.sqrt(0.5 * np.sum(self.amplitude**2)))

    def phasors(self, x: ArrayLike, y: ArrayLike) -> NDArray[np.complex128]:
        """Elevation phasors Z (..., N) [m] at x, y (m): `zeta = Re(sum Z exp(-i omega t))`.

        A response with the transfer function `RAO` is `Re(sum RAO Z exp(-i omega t))`.
        """
        x, y = np.asarray(x, dtype=float)[..., None], np.asarray(y, dtype=float)[..., None]
        along = x * np.cos(self.direction) + y * np.sin(self.direction)
        return self.amplitude * np.exp(1j * (self.wavenumber * along + self.phase))

    def elevation(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Height zeta (...) of the surface above still water, m, at x, y (m) and t (s)."""
        return self._blocks(lambda p: np.cos(self._theta(*p)) @ self.amplitude, (), x, y, t)

    def potential(self, x: ArrayLike, y: ArrayLike, z: ArrayLike, t: ArrayLike) -> Array:
        """Velocity potential phi (...) [m2/s] at x, y, z (m, NWU) and t (s)."""
        weight = self.amplitude * self.gravity / self.omega

        def block(points: Array) -> Array:
            theta, C, _ = self._terms(*points)
            return (C * np.sin(theta)) @ weight

        return self._blocks(block, (), x, y, z, t)

    def velocity(self, x: ArrayLike, y: ArrayLike, z: ArrayLike, t: ArrayLike) -> Array:
        """Water velocity (..., 3) [m/s, NWU] at x, y, z (m, NWU) and t (s)."""
        return self._vector(1.0, x, y, z, t)

    def acceleration(self, x: ArrayLike, y: ArrayLike, z: ArrayLike, t: ArrayLike) -> Array:
        """Local acceleration dv/dt (..., 3) [m/s2, NWU] at x, y, z (m, NWU) and t (s).

        The convective part is `gradient(...) @ velocity(...)`.
        """
        # d/dt is a quarter period ahead: theta - pi/2 with the weight omega.
        return self._vector(self.omega, x, y, z, t, shift=0.5 * np.pi)

    def gradient(self, x: ArrayLike, y: ArrayLike, z: ArrayLike, t: ArrayLike) -> Array:
        """Velocity gradient dv_i/dx_j (..., 3, 3) [1/s, NWU]: symmetric and without trace.

        Args:
            x, y, z: point, m, NWU.
            t: time, s.
        """
        c, s = np.cos(self.direction), np.sin(self.direction)
        weight = self.amplitude * self.gravity * self.wavenumber**2 / self.omega
        in_plane = weight[:, None] * np.stack([-c * c, -c * s, -s * s, np.ones_like(c)], axis=-1)
        mixed = weight[:, None] * np.stack([c, s], axis=-1)

        def block(points: Array) -> Array:
            theta, C, S = self._terms(*points)
            xx, xy, yy, zz = np.moveaxis((C * np.sin(theta)) @ in_plane, -1, 0)
            xz, yz = np.moveaxis((S * np.cos(theta)) @ mixed, -1, 0)
            return np.stack([xx, xy, xz, xy, yy, yz, xz, yz, zz], axis=-1).reshape(-1, 3, 3)

        return self._blocks(block, (3, 3), x, y, z, t)

    def pressure(
        self, x: ArrayLike, y: ArrayLike, z: ArrayLike, t: ArrayLike, water_density: float = 1025.0
    ) -> Array:
        """Dynamic pressure `-rho dphi/dt` (...) [Pa]; the hydrostatic part is `-rho g z`.

        Args:
            x, y, z: point, m, NWU.
            t: time, s.
            water_density: rho, kg/m3.
        """
        weight = water_density * self.gravity * self.amplitude

        def block(points: Array) -> Array:
            theta, C, _ = self._terms(*points)
            return (C * np.cos(theta)) @ weight

        return self._blocks(block, (), x, y, z, t)

    def _blocks(
        self, block: Callable[[Array], Array], shape: tuple[int, ...], *points: ArrayLike
    ) -> Array:
        """`block` over the broadcast points, a limited number of them at a time."""
        arrays = np.broadcast_arrays(*[np.asarray(p, dtype=float) for p in points])
        flat = np.stack([a.ravel() for a in arrays])
        step = max(1, _BLOCK // max(1, len(self.omega)))
        result = np.empty((flat.shape[1], *shape))
        for start in range(0, flat.shape[1], step):
            result[start : start + step] = block(flat[:, start : start + step])
        return result.reshape(arrays[0].shape + shape)[()]

    def _theta(self, x: Array, y: Array, t: Array) -> Array:
        """Phase angles (P, N) at points (P,)."""
        k_x, k_y = (self.wavenumber * f(self.direction) for f in (np.cos, np.sin))
        return np.outer(x, k_x) + np.outer(y, k_y) - np.outer(t, self.omega) + self.phase

    def _terms(self, x: Array, y: Array, z: Array, t: Array) -> tuple[Array, Array, Array]:
        """theta, C = cosh k(z'+h) / cosh kh and S = sinh k(z'+h) / cosh kh, (P, N) each."""
        theta = self._theta(x, y, t)
        if self.stretching == "wheeler":
            zeta = np.cos(theta) @ self.amplitude
            z = (z - zeta) / np.maximum(1 + zeta / self.depth, LEAST_WATER)
        if self.stretching != "none":
            z = np.minimum(z, 0.0)
        kz = np.outer(np.maximum(z, -self.depth), self.wavenumber)
        up = np.exp(kz)
        if np.isinf(self.depth):
            return theta, up, up
        # Written with decaying exponentials only, so that no depth overflows.
        down = np.exp(-kz - 2 * self.wavenumber * self.depth)
        scale = 1 / (1 + np.exp(-2 * self.wavenumber * self.depth))
        return theta, scale * (up + down), scale * (up - down)

    def _vector(self, factor: Array | float, *points: ArrayLike, shift: float = 0.0) -> Array:
        """Velocity with theta turned back by `shift`, each component times `factor`."""
        speed = factor * self.amplitude * self.gravity * self.wavenumber / self.omega
        along = speed[:, None] * np.stack([np.cos(self.direction), np.sin(self.direction)], axis=-1)

        def block(p: Array) -> Array:
            theta, C, S = self._terms(*p)
            theta -= shift
            return np.column_stack([(C * np.cos(theta)) @ along, (S * np.sin(theta)) @ speed])

        return self._blocks(block, (3,), *points)
