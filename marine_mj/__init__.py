"""marine_mj: marine vehicle simulation on MuJoCo.

Importing the package installs its native callbacks in MuJoCo; a model without marine numerics
behaves exactly as in plain MuJoCo.
"""

from marine_mj.errors import MarineMjError
from marine_mj.hydrodynamics.native import install, self_test

install()
self_test()

from marine_mj.hydrodynamics.loader import load, load_xml  # noqa: E402
from marine_mj.hydrodynamics.wrenches import check_state, wrenches  # noqa: E402

__all__ = ["MarineMjError", "check_state", "load", "load_xml", "wrenches"]
__version__ = "0.1.0"
