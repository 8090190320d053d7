"""Drag coefficients from measured points, against the laws they come from."""

import numpy as np
import pytest

from marine_mj.errors import ModelError
from marine_mj.hydrodynamics.estimates import fit_drag

SPEED = np.array([-1.5, -0.5, 0.3, 0.8, 1.1, 2.0])


def test_exact_laws_come_back():
    force = 3.0 * SPEED + 42.1 * np.abs(SPEED) * SPEED
    both = fit_drag(SPEED, force)["both"]
    # measured: 4e-15
    assert (both.linear, both.quadratic) == pytest.approx((3.0, 42.1), rel=1e-12)
    assert both.rms < 1e-12
    np.testing.assert_allclose(both.force(SPEED), force, rtol=1e-12)
    quadratic = fit_drag(SPEED, 42.1 * np.abs(SPEED) * SPEED)
    assert quadratic["quadratic"].quadratic == pytest.approx(42.1, rel=1e-12)
    assert quadratic["quadratic"].linear == 0.0 and quadratic["linear"].quadratic == 0.0
    assert quadratic["linear"].rms > 5


def test_one_term_fits_are_the_normal_equations():
    force = np.random.default_rng(0).normal(size=6)
    found = fit_drag(SPEED, force)
    squares = np.abs(SPEED) * SPEED
    assert found["linear"].linear == pytest.approx(SPEED @ force / (SPEED @ SPEED))
    assert found["quadratic"].quadratic == pytest.approx(squares @ force / (squares @ squares))
    assert found["both"].rms <= min(found["linear"].rms, found["quadratic"].rms)


@pytest.mark.parametrize(
    ("speed", "force", "message"),
    [
        ([1.0, 2.0], [1.0], r"speed \(2,\) and force \(1,\) must be two rows of finite numbers"),
        ([1.0, np.nan], [1.0, 2.0], "must be two rows of finite numbers"),
        ([1.0, -1.0, 0.0], [1.0, -1.0, 0.0], "1 different speeds besides 0 do not tell linear"),
    ],
)
def test_refusals(speed, force, message):
    with pytest.raises(ModelError, match=message):
        fit_drag(speed, force)
