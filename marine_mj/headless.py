"""Importing dm_control on machines without a display or without OpenGL.

dm_control chooses its OpenGL platform when it is imported: it takes GLFW if nothing is set, which
needs a display, and fails if the platform that is set does not load. Simulation needs neither, so
importing this module first imports dm_control's renderer with EGL as the default, and with none
if that does not load. The environment variable is left as the user set it.
"""

import importlib
import os
import sys

_VARIABLE = "MUJOCO_GL"
_RENDERER = "dm_control._render"


def _import_renderer() -> str:
    """Import dm_control's renderer; the name of the platform it got."""
    wanted = os.environ.get(_VARIABLE)
    for platform in (wanted or "egl", "disable"):
        os.environ[_VARIABLE] = platform
        try:
            return str(importlib.import_module(_RENDERER).BACKEND)
        # Broken drivers raise many kinds of exception while they load.
        except Exception:
            for name in [n for n in sys.modules if n.startswith(_RENDERER)]:
                del sys.modules[name]
        finally:
            if wanted is None:
                del os.environ[_VARIABLE]
            else:
                os.environ[_VARIABLE] = wanted
    return "disable"


#: Platform that dm_control renders with.
PLATFORM = _import_renderer()
