"""marine_mj: marine vehicle simulation on MuJoCo."""

__version__ = "0.1.0"
