"""Closed forms of a body on a spring and damper that push but do not pull.

`m x'' = -(k x + c x')` from the first touch until the force is zero; no other force. The damping
ratio is `zeta = c / (2 sqrt(k m))`.
"""

from functools import lru_cache

import numpy as np

#: Smallest coefficient of restitution: a linear damper needs infinite damping for none.
LOWEST_RESTITUTION = 0.01


def restitution_of(zeta: float) -> float:
    """Speed after over speed before an impact, 1, of a damping ratio.

    Source: Schwager and Poeschel (2007), Granular Matter 9, eqs 19-21: the contact ends when the
    force is zero, not when the spring is at its length again.
    """
    if zeta <= 0:
        return 1.0
    if zeta < 1:
        omega = np.sqrt(1 - zeta**2)
        angle = np.pi - np.arctan2(2 * zeta * omega, omega**2 - zeta**2)
        return float(np.exp(-zeta / omega * angle))
    if zeta < 1 + 1e-9:
        return float(np.exp(-2.0))
    omega = np.sqrt(zeta**2 - 1)
    # (zeta + omega) / (zeta - omega), without the difference of two near numbers
    return float(np.exp(-2 * zeta / omega * np.log(zeta + omega)))


@lru_cache(maxsize=256)
def damping_ratio(restitution: float) -> float:
    """Damping ratio, 1, that gives a coefficient of restitution of 0.01 to 1."""
    low, high = 0.0, 10.0
    for _ in range(80):
        middle = 0.5 * (low + high)
        if restitution_of(middle) > restitution:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def _phase(zeta: float) -> float:
    """Time of the largest force, as `t sqrt(k / m)`; 0 from a damping ratio of 1/2 on."""
    if zeta >= 0.5:
        return 0.0
    omega = np.sqrt(1 - zeta**2)
    return float(np.arctan2(omega * (1 - 4 * zeta**2), zeta * (3 - 4 * zeta**2)) / omega)


def peak_force(mass: float, speed: float, stiffness: float, damping: float = 0.0) -> float:
    """Largest force, N, on a mass (kg) that arrives at a speed (m/s).

    `v sqrt(k m)` without damping, and again at half of critical damping; from there on it is the
    damper at first touch, `c v`.
    """
    scale = speed * np.sqrt(stiffness * mass)
    zeta = damping / (2 * np.sqrt(stiffness * mass))
    if zeta >= 0.5:
        return float(2 * zeta * scale)
    # x'' = -f / m is the acceleration of a damped oscillator that starts with the speed v
    t, omega = _phase(zeta), np.sqrt(1 - zeta**2)
    decay = np.exp(-zeta * t)
    x = decay * np.sin(omega * t) / omega
    rate = decay * (np.cos(omega * t) - zeta / omega * np.sin(omega * t))
    return float(scale * (x + 2 * zeta * rate))


def deepest(mass: float, speed: float, stiffness: float, damping: float = 0.0) -> float:
    """Largest compression of the spring, m: `v sqrt(m / k)` without damping."""
    zeta = damping / (2 * np.sqrt(stiffness * mass))
    if zeta < 1:
        omega = np.sqrt(1 - zeta**2)
        t = np.arctan2(omega, zeta) / omega
    elif zeta > 1:
        omega = np.sqrt(zeta**2 - 1)
        t = np.log(zeta + omega) / omega
    else:
        t = 1.0
    return float(speed * np.sqrt(mass / stiffness) * np.exp(-zeta * t))


def contact_time(mass: float, stiffness: float, damping: float = 0.0) -> float:
    """Time from first touch until the force is zero, s: `pi sqrt(m / k)` without damping."""
    zeta = damping / (2 * np.sqrt(stiffness * mass))
    if zeta == 0:
        phase = np.pi
    else:
        phase = -np.log(restitution_of(zeta)) / zeta
    return float(phase * np.sqrt(mass / stiffness))
