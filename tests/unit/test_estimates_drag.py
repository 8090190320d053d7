"""Drag and resistance against published figures."""

import numpy as np
import pytest
from conftest import model_error

from marine_mj.hydrodynamics.estimates import (
    froude_number,
    hoerner_cross_flow_coefficient,
    hull_resistance,
    ittc57_friction,
    morison_force,
    quadratic_drag,
    reynolds_number,
    streamlined_form_factor,
)

RHO = 1025.0


def test_drag_of_the_rod():
    # Axial rod, 0.1 x 0.5 m at 0.176 m/s: 0.1034 N in fresh water (panel and CFD study).
    D = quadratic_drag(0.849881, np.pi * 0.1**2 / 4, 1000)
    assert D * 0.176**2 == pytest.approx(0.1034, abs=5e-5)
    assert reynolds_number(0.176, 0.5, 1e-6) == pytest.approx(8.8e4, rel=1e-12)


def test_morison():
    kwargs = {"diameter": 0.2, "drag_coefficient": 1.1, "added_mass_coefficient": 1.0}
    A = np.pi / 4 * 0.2**2
    steady = morison_force(-2.0, 0.0, density=RHO, **kwargs)
    assert steady == pytest.approx(-0.5 * RHO * 1.1 * 0.2 * 4)
    # A body that moves with the water feels the pressure gradient alone.
    along = morison_force(1.0, 3.0, 1.0, 3.0, density=RHO, **kwargs)
    assert along == pytest.approx(RHO * A * 3)
    held = morison_force([0.0, 0.0], [1.0, -1.0], density=RHO, **kwargs)
    np.testing.assert_allclose(held, [2 * RHO * A, -2 * RHO * A])


def test_hoerner():
    # Viknes: 0.6831 at B/(2T) = 1.693; ALERD: 0.7881 at 20/17. Measured: 0.68307, 0.78809.
    assert hoerner_cross_flow_coefficient(2 * 1.693, 1) == pytest.approx(0.6831, abs=2e-4)
    assert hoerner_cross_flow_coefficient(20, 8.5) == pytest.approx(0.7881, abs=1e-4)
    values = [hoerner_cross_flow_coefficient(2 * r, 1) for r in np.linspace(0.011, 4, 200)]
    assert (np.diff(values) <= 0).all()


def test_resistance_of_the_carrier():
    # ALERD at 8.5 kn: C_F0 1.82408e-3, C_T 1.93415e-3, 81.31 kN (form effects twice, as there).
    # Measured: 81.312 kN.
    speed = 8.5 * 1852 / 3600
    C_F = ittc57_friction(2.58362e8)
    assert C_F == pytest.approx(1.82408e-3, abs=5e-9)
    form = streamlined_form_factor(8.5, 80)
    assert C_F * form == pytest.approx(1.93415e-3, abs=1e-8)
    viscosity = speed * 80 / 2.58362e8
    R = hull_resistance(speed, 80, 3900, RHO, viscosity, form_factor=1.1 * form)
    assert R == pytest.approx(81.31e3, abs=10)
    assert hull_resistance(-speed, 80, 3900, RHO, viscosity, form_factor=1.1 * form) == -R
    assert hull_resistance(0, 80, 3900, RHO, viscosity) == 0
    # ITTC's own figure: 3.0e-3 at Re = 1e7.
    assert ittc57_friction(1e7) == pytest.approx(3.0e-3, rel=1e-12)
    rough = hull_resistance(speed, 80, 3900, RHO, viscosity, allowance=4e-4)
    smooth = hull_resistance(speed, 80, 3900, RHO, viscosity)
    assert rough - smooth == pytest.approx(0.5 * RHO * 3900 * 4e-4 * speed**2)


@pytest.mark.parametrize(
    "call, parts",
    [
        (lambda: quadratic_drag(-1, 1, RHO), ["drag_coefficient = -1"]),
        (lambda: hoerner_cross_flow_coefficient(10, 1), ["B/(2T) = 5", "4.003", "0.5593"]),
        (lambda: ittc57_friction(50), ["50", "10000", "above"]),
        (lambda: hull_resistance(1e-6, 1, 1, RHO, 1e-6), ["Reynolds number 1 ", "above"]),
        (lambda: streamlined_form_factor(2, 1), ["diameter = 2", "length = 1"]),
        (lambda: reynolds_number(np.inf, 1, 1e-6), ["speed = inf", "not finite"]),
        (lambda: froude_number(1, -1), ["length = -1"]),
    ],
)
def test_refusals(call, parts):
    with model_error(*parts):
        call()
