"""The radiation memory of a body in the packed table, and its states in `data.act`."""

import mujoco
import numpy as np

from marine_mj.errors import ModelError
from marine_mj.frames import Array
from marine_mj.hydrodynamics import table as t_
from marine_mj.hydrodynamics.memory import Memory
from marine_mj.hydrodynamics.vector_fitting import Complex

#: Prefix of the actuators whose activations are the states of a radiation memory.
MEMORY_PREFIX = "marine_mj/memory/"


def memory_element(model: mujoco.MjModel, name: str, memory: Memory) -> Array:
    """Parameters of the element MEMORY (table.MM_*) of the body `name`.

    Raises:
        ModelError: there are more poles than the kernel has room for.
    """
    if len(memory.poles) > t_.MAX_POLES:
        raise ModelError(
            f"the radiation memory of {name!r} has {len(memory.poles)} poles, allowed are "
            f"{t_.MAX_POLES}: fit it with a lower order"
        )
    address = model.actuator_actadr[model.actuator(MEMORY_PREFIX + name).id]
    order = np.concatenate([np.zeros(0, dtype=int), *(poles for _, poles in memory.groups)])
    poles = memory.poles[order]
    inverse = 1 / poles
    parts = [[address, len(poles), len(memory.groups)], poles.real, poles.imag]
    parts += [inverse.real, inverse.imag]
    first = 0
    for dofs, own in memory.groups:
        parts += [[len(dofs), len(own), first], np.pad(dofs, (0, 6 - len(dofs)))]
        residues = memory.residues[np.ix_(own, dofs, dofs)].transpose(2, 1, 0)  # driver, answer
        parts.append(np.stack([residues.real, residues.imag], axis=2).ravel())
        first += len(own)
    return np.concatenate(parts)


def memory_state(q: Array, nu: Array, waves: tuple[Array, Complex] | None, time: float) -> Array:
    """States (n,) of a memory whose body has moved so for long, at `time`.

    The solution of `z' = lambda z + nu + Re sum -i omega X exp(-i omega t)` without transients.

    Args:
        q: parameters of the element MEMORY.
        nu: (6,) constant velocity relative to the current, level axes.
        waves: omega (m,) rad/s and motion amplitudes X (6, m), level axes; None: none.
        time: s.
    """
    count = int(q[t_.MM_POLES])
    parts = q[t_.MM_DATA : t_.MM_DATA + 2 * count]
    poles = (parts[:count] + 1j * parts[count:])[:, None]
    z = -nu / poles
    if waves is not None:
        omega, X = waves
        V = -1j * omega * X * np.exp(-1j * omega * time)
        z = z + 0.5 * ((1 / (-1j * omega - poles)) @ V.T + (1 / (1j * omega - poles)) @ V.conj().T)
    states, place = [], t_.MM_DATA + 4 * count
    for _ in range(int(q[t_.MM_GROUPS])):
        m, n, first = (int(v) for v in q[place : place + 3])
        for dof in q[place + t_.MG_DOF : place + t_.MG_DOF + m].astype(int):
            own = z[first : first + n, dof]
            states += [own.real, own.imag]
        place += t_.MG_RESIDUES + 2 * m * m * n
    return np.concatenate(states)
