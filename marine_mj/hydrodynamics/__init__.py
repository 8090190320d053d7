"""Hydrodynamic coefficients, native kernels and the model loader."""
