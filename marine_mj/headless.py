"""Importing MuJoCo and dm_control on machines without a display or without OpenGL.

Both choose their OpenGL platform when they are imported and fail if the one that MUJOCO_GL names
does not load; dm_control takes GLFW if none is named, which needs a display. Simulation needs
neither: here they are imported with the user's choice or EGL, and with no platform at all if that
does not load. The environment variable is left as the user set it.
"""

import importlib
import os
import sys
from types import ModuleType

_VARIABLE = "MUJOCO_GL"
#: Modules that keep a platform which did not load.
_HALF_LOADED = ("OpenGL", "mujoco.egl", "mujoco.osmesa", "mujoco.gl_context", "dm_control._render")


def tolerant_import(name: str) -> ModuleType:
    """The module `name`, without OpenGL if OpenGL does not load.

    Raises:
        ImportError: the module cannot be imported without OpenGL either.
    """
    wanted = os.environ.get(_VARIABLE)
    try:
        for platform in (wanted or "egl", "disable"):
            os.environ[_VARIABLE] = platform
            try:
                return importlib.import_module(name)
            # Broken drivers raise many kinds of exception while they load.
            except Exception:
                if platform == "disable":
                    raise
                for module in [m for m in sys.modules if m.startswith(_HALF_LOADED)]:
                    del sys.modules[module]
    finally:
        if wanted is None:
            del os.environ[_VARIABLE]
        else:
            os.environ[_VARIABLE] = wanted
    raise ImportError(name)
