"""Meshes, textures and hydrodynamic databases, with the scripts that made them."""
