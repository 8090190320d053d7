"""The sea bed of a scene of finite depth: a plane that vehicles touch."""

import mujoco

from marine_mj.errors import ScenarioError
from marine_mj.hydrodynamics.table import SEA_BED
from marine_mj.scenario import Scenario

#: Sliding, torsional and rolling friction (a choice of ours: MuJoCo's default but for the first,
#: lower because a hull on sand slides before it tips).
FRICTION = (0.5, 0.005, 0.0001)
#: How far a vehicle may start in the sea bed, m.
TOLERANCE = 1e-3


def add_sea_bed(spec: mujoco.MjSpec, depth: float) -> None:
    """Add the bed of water `depth` m deep to a scene; it touches all that collides."""
    spec.worldbody.add_geom(
        name=SEA_BED,
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[0.0, 0.0, 1.0],  # endless
        pos=[0.0, 0.0, -depth],
        friction=FRICTION,
        group=3,  # hidden like all collision shapes: `water.add_scenery` draws sand there
    )


def check_start(scenario: Scenario, model: mujoco.MjModel) -> None:
    """Refuse a vehicle whose collision shapes reach into the sea bed where it starts.

    Without contacts only the body origin counts, which the scenario checks itself.

    Raises:
        ScenarioError: one does.
    """
    if scenario.sea.depth is None:
        return
    data = mujoco.MjData(model)
    mujoco.mj_fwdPosition(model, data)
    bed = model.geom(SEA_BED).id
    for contact in data.contact:
        if bed in contact.geom and contact.dist < -TOLERANCE:
            geom = model.geom(int(contact.geom.sum()) - bed).name
            raise ScenarioError(
                f"scenario {scenario.name!r}: {geom!r} starts {-contact.dist:.3g} m below the sea "
                f"bed at sea.depth = {scenario.sea.depth:g} m: start that vehicle higher, or take "
                "deeper water"
            )
