"""Shared building blocks of the tests: small models written as MJCF, and refusals."""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest

import marine_mj  # noqa: F401  (installs the native callbacks)
from marine_mj.errors import ModelError
from marine_mj.frames import skew


def numbers(values) -> str:
    """Numbers as MJCF text without loss of digits."""
    return " ".join(repr(float(v)) for v in np.ravel(values))


def numeric(quantity, data, body="a") -> str:
    """A numeric of a body."""
    return f'<numeric name="{body}.{quantity}" data="{data}"/>'


def one_body(
    *,
    added_mass=None,
    numerics="",
    mass=10.0,
    center="0.02 0.01 -0.05",
    inertia="1 2 3",
    integrator="implicitfast",
    timestep=0.005,
    gravity=9.81,
    pos="0 0 -10",
    extra="",
    option="",
    world="",
    tail="",
) -> str:
    """MJCF of one free body `a` with a thruster along x at its origin."""
    coefficients = numerics
    if added_mass is not None:
        coefficients += f'<numeric name="a.added_mass_flu" data="{numbers(added_mass)}"/>'
    return f"""<mujoco>
    <option timestep="{timestep}" integrator="{integrator}" gravity="0 0 {-gravity}" {option}/>
    <custom>{coefficients}</custom>
    <worldbody>{world}
      <body name="a" pos="{pos}"><freejoint name="a"/>
        <inertial pos="{center}" mass="{mass}" diaginertia="{inertia}"/>
        <site name="s"/>{extra}
      </body>
    </worldbody>
    <actuator><motor name="t" site="s" gear="1 0 0 0 0 0"/></actuator>{tail}
    </mujoco>"""


def with_database(name, owner="a") -> str:
    """MJCF of the body `a` with a wave database, which may be another one's."""
    text = f'<text name="{owner}.wave_database" data="{name}"/>'
    return one_body(added_mass=np.ones(6), numerics=text)


@contextmanager
def model_error(*parts) -> Iterator[None]:
    """Expect a ModelError with all parts in its message."""
    with pytest.raises(ModelError) as error:
        yield
    for part in parts:
        assert part in str(error.value), str(error.value)


def random_added_mass(seed=0, scale=3.0):
    """Random full, coupled, positive definite 6x6."""
    B = np.random.default_rng(seed).normal(size=(6, 6))
    return scale * B @ B.T


def rigid_mass(mass, center, inertia):
    """M_RB (6, 6) about the body origin from mass, CG and inertia (3,) about the CG."""
    S = skew(center)
    return np.block([[mass * np.eye(3), -mass * S], [mass * S, np.diag(inertia) - mass * S @ S]])


def kirchhoff(M, nu):
    """Right-hand side of `M nu_dot = ...` without external forces (Lamb 1932, art. 124)."""
    p = M @ nu
    v, w = nu[:3], nu[3:]
    return -np.concatenate([np.cross(w, p[:3]), np.cross(w, p[3:]) + np.cross(v, p[:3])])


@pytest.fixture
def rng():
    """Seeded generator."""
    return np.random.default_rng(7)


@pytest.fixture
def log_elsewhere(tmp_path, monkeypatch):
    """MuJoCo writes its warnings to MUJOCO_LOG.TXT in the working folder."""
    monkeypatch.chdir(tmp_path)
