"""Hydrodynamic data from the boundary element method (Capytaine, extra `bem`)."""
