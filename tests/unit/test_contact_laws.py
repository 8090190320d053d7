"""Closed forms of a spring and damper against an integrator."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from marine_mj.hydrodynamics import contact_laws as laws


@pytest.mark.parametrize("zeta", [0.0, 0.1, 0.3, 0.45, 0.5, 0.7, 1.0, 1.5, 4.0])
def test_closed_forms_equal_an_integration_until_the_force_is_zero(zeta):
    k, m, v = 1e5, 100.0, 0.7
    c = 2 * zeta * np.sqrt(k * m)

    def force(t, y):
        return k * y[0] + c * y[1] if t > 1e-9 else 1.0

    force.terminal, force.direction = True, -1
    done = solve_ivp(
        lambda t, y: [y[1], -(k * y[0] + c * y[1]) / m],
        (0, 10),
        [0, v],
        events=force,
        rtol=1e-10,
        atol=1e-13,
        max_step=2e-4,
    )
    # measured: peaks within 4e-6 (sampling), time and speed 3e-11
    assert laws.peak_force(m, v, k, c) == pytest.approx((k * done.y[0] + c * done.y[1]).max(), 2e-5)
    assert laws.deepest(m, v, k, c) == pytest.approx(done.y[0].max(), 2e-5)
    assert laws.contact_time(m, k, c) == pytest.approx(done.t[-1], 1e-8)
    assert laws.restitution_of(zeta) == pytest.approx(-done.y[1, -1] / v, 1e-8)


@pytest.mark.parametrize("restitution", [0.01, 0.1, np.exp(-2), 0.3, 0.5, 0.9, 0.999])
def test_damping_ratio_gives_the_restitution_it_was_asked_for(restitution):
    zeta = laws.damping_ratio(restitution)
    assert laws.restitution_of(zeta) == pytest.approx(restitution, rel=1e-9)
