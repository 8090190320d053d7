"""Stacking and selecting nested dataclasses."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
import pytest
from marine_mj.controllers import RigidState

from marine_mj import trees


@dataclass(frozen=True)
class Gains:
    P: float
    limits: np.ndarray
    name: str = "a"
    order: int = 2


@dataclass(frozen=True)
class Controller:
    gains: Gains
    corridor: tuple[float, float] = (1.0, 2.0)
    seen: int = field(default=0, metadata={"stack": "first"})
    shared: np.ndarray = field(default_factory=lambda: np.ones(2), metadata={"stack": "same"})


def controller(P=1.0, high=3.0, **changes):
    return Controller(Gains(P, np.array([0.0, high])), **changes)


def test_numbers_that_differ_get_a_row_each_and_equal_ones_stay():
    one = trees.stack([controller(P=1.0), controller(P=2.0), controller(P=2.0)])
    np.testing.assert_array_equal(one.gains.P, [1.0, 2.0, 2.0])
    np.testing.assert_array_equal(one.gains.limits, [0.0, 3.0])
    assert one.corridor == (1.0, 2.0)
    wide = trees.stack([controller(high=4.0), controller(high=5.0, corridor=(1.0, 7.0))])
    np.testing.assert_array_equal(wide.gains.limits, [[0.0, 4.0], [0.0, 5.0]])
    np.testing.assert_array_equal(wide.corridor, [[1.0, 2.0], [1.0, 7.0]])


def test_simulations_may_share_trees():
    trees_ = [controller(P=1.0, high=4.0), controller(P=2.0, high=5.0)]
    rows = np.array([1, 0, 1])
    one, same = trees.stack(trees_, rows), trees.stack([trees_[i] for i in rows])
    np.testing.assert_array_equal(one.gains.P, [2.0, 1.0, 2.0])
    np.testing.assert_array_equal(one.gains.limits, same.gains.limits)
    assert one.corridor == (1.0, 2.0)


def test_structure_that_differs_is_refused():
    a = Controller(Gains(1.0, np.zeros(2)))
    for other, message in (
        (Controller(Gains(1.0, np.zeros(2), name="b")), "'a' and 'b' differ"),
        (Controller(Gains(1.0, np.zeros(2), order=3)), "2 and 3 differ"),
        (Controller(Gains(1.0, np.zeros(3))), "shapes"),
        (Controller(Gains(1.0, np.zeros(2)), shared=np.zeros(2)), "shared differs"),
    ):
        with pytest.raises(trees.StructureError, match=message):
            trees.stack([a, other])


@dataclass(frozen=True)
class Whole:
    stack_rule: ClassVar[str] = "same"
    noise: float
    sensor: Gains | None = None


def test_a_class_may_ask_to_be_the_same_in_all():
    sensor = Gains(1.0, np.zeros(2))
    assert trees.stack([Whole(1.0, sensor), Whole(1.0, sensor)]) == Whole(1.0, sensor)
    for other in (Whole(2.0, sensor), Whole(1.0)):
        with pytest.raises(trees.StructureError, match="Whole differs between the simulations"):
            trees.stack([Whole(1.0, sensor), other])


def test_a_field_may_be_left_out_of_the_comparison():
    assert trees.stack([controller(seen=1), controller(seen=2)]).seen == 1


def test_take_selects_rows_of_every_array():
    one = Gains(np.arange(4.0), np.arange(8.0).reshape(4, 2))
    some = trees.take(one, np.array([False, True, False, True]))
    np.testing.assert_array_equal(some.P, [1.0, 3.0])
    np.testing.assert_array_equal(some.limits, [[2.0, 3.0], [6.0, 7.0]])
    assert trees.take(one, 2).P == 2.0 and some.name == "a"


def test_cached_properties_are_made_again():
    many = RigidState(np.zeros((3, 3)), np.tile([1.0, 0, 0, 0], (3, 1)), np.zeros((3, 6)))
    assert many.rotation.shape == (3, 3, 3)
    assert trees.take(many, slice(2)).rotation.shape == (2, 3, 3)
    turned = RigidState(many.position, np.tile([0.0, 0, 0, 1], (3, 1)), many.velocity)
    both = trees.stack([many, turned])
    np.testing.assert_allclose(both.rotation[1, 0], np.diag([-1.0, -1.0, 1.0]), atol=1e-15)
