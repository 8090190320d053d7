"""Native kernels: compiled by numba, cached on disk, called by MuJoCo without Python."""
