"""Noise as a pure function of (seed of the run, step): no state, the same bits alone or in a batch.

Counter-based: Philox4x32-10 (Salmon et al. 2011, "Parallel random numbers: as easy as 1, 2, 3")
turns (seed; column, channel, step) into 128 random bits. Any row can be had at any time, in any
order, so a stream need not be stored, copied or advanced.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from marine_mj.frames import Array
from marine_mj.native_loops import native_loop

_MASK = np.uint64(0xFFFFFFFF)
_HALF = np.uint64(32)
# Multipliers and Weyl increments of Philox4x32 (Salmon et al. 2011, section 3.3).
_M0, _M1 = np.uint64(0xD2511F53), np.uint64(0xCD9E8D57)
_W0, _W1 = np.uint64(0x9E3779B9), np.uint64(0xBB67AE85)
_UNIT = 2.0**-32


@njit(cache=True)
def philox(c0, c1, c2, c3, k0, k1):
    """Four random words from a counter of four words and a key of two (uint64 below 2**32)."""
    for _ in range(10):
        low, high = _M0 * c0, _M1 * c2
        c0, c1, c2, c3 = (
            (high >> _HALF) ^ c1 ^ k0,
            high & _MASK,
            (low >> _HALF) ^ c3 ^ k1,
            low & _MASK,
        )
        k0 = (k0 + _W0) & _MASK
        k1 = (k1 + _W1) & _MASK
    return c0, c1, c2, c3


@native_loop("void(u8, u8, u8, f8[:], f8[:])", "(),(),(),(w)->(w)")
def _normals(seed, step, channel, _, out):
    for first in range(0, out.shape[0], 4):
        words = philox(
            np.uint64(first),
            channel,
            step & _MASK,
            step >> _HALF,
            seed & _MASK,
            seed >> _HALF,
        )
        for pair in range(2):
            i = first + 2 * pair
            if i >= out.shape[0]:
                break
            u, v = (words[0], words[1]) if pair == 0 else (words[2], words[3])
            # Box and Muller 1958; half a unit keeps the logarithm finite.
            radius = np.sqrt(-2.0 * np.log((np.float64(u) + 0.5) * _UNIT))
            angle = 2.0 * np.pi * (np.float64(v) + 0.5) * _UNIT
            out[i] = radius * np.cos(angle)
            if i + 1 < out.shape[0]:
                out[i + 1] = radius * np.sin(angle)


@native_loop("void(u8, u8, u8, f8[:], f8[:])", "(),(),(),(w)->(w)")
def _uniforms(seed, step, channel, _, out):
    for first in range(0, out.shape[0], 4):
        a, b, c, d = philox(
            np.uint64(first) | np.uint64(0x80000000),
            channel,
            step & _MASK,
            step >> _HALF,
            seed & _MASK,
            seed >> _HALF,
        )
        for i in range(first, min(first + 4, out.shape[0])):
            word = a
            if i == first + 1:
                word = b
            elif i == first + 2:
                word = c
            elif i == first + 3:
                word = d
            out[i] = (np.float64(word) + 0.5) * _UNIT


@dataclass(frozen=True)
class NoiseStream:
    """Independent standard noise for every run, step and channel.

    Attributes:
        seeds: (...,) non-negative whole numbers below 2**64, one per run.
        width: numbers per run and step.
        channel: separates streams of one run: each sensor has its own.
    """

    seeds: NDArray[np.uint64]
    width: int
    channel: int = 0

    def rows(self, step: int) -> Array:
        """Standard normal numbers (..., width) of a step (0, 1, ...)."""
        return _normals(*self._key(step), np.empty(self.width))

    def uniform(self, step: int) -> Array:
        """Numbers (..., width) of a step, uniform in (0, 1), independent of `rows`."""
        return _uniforms(*self._key(step), np.empty(self.width))

    def _key(self, step: int) -> tuple[NDArray[np.uint64], np.uint64, np.uint64]:
        """Seed, step and channel as the kernels take them."""
        return np.asarray(self.seeds, dtype=np.uint64), np.uint64(step), np.uint64(self.channel)


def as_seeds(seeds: ArrayLike, shape: tuple[int, ...] = ()) -> NDArray[np.uint64]:
    """Seeds (...,) of runs as `NoiseStream` takes them, for a leading shape."""
    return np.broadcast_to(np.asarray(seeds, dtype=np.uint64), shape).copy()
