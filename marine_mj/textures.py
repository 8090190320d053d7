"""Procedural pictures of sky, seabed and small ripples, from NumPy alone (no image files).

Colours are linear factors of display red, green, blue in [0, 1]; textures are uint8.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Image = NDArray[np.uint8]
Float = NDArray[np.float32]
Rgb = tuple[float, float, float]


@dataclass(frozen=True)
class Palette:
    """Colours of sky, water and sand; the default is a bright, slightly hazy day at sea.

    Attributes:
        zenith, horizon: sky overhead and at the horizon (the haze that far water fades into).
        deep, scatter: water seen from above in a trough, and light coming through a crest.
        foam: whitecaps.
        murk: what under water fades into; `murk_range` is the visibility, m.
        window, underside: the surface from below inside and outside Snell's window.
        sand: seabed.
        sun: unit vector towards the sun, NWU.
    """

    zenith: Rgb = (0.27, 0.47, 0.72)
    horizon: Rgb = (0.80, 0.86, 0.90)
    deep: Rgb = (0.025, 0.135, 0.205)
    scatter: Rgb = (0.05, 0.33, 0.37)
    foam: Rgb = (0.90, 0.94, 0.95)
    murk: Rgb = (0.055, 0.315, 0.405)
    murk_range: float = 42.0
    window: Rgb = (0.66, 0.90, 0.90)
    underside: Rgb = (0.06, 0.34, 0.42)
    sand: Rgb = (0.62, 0.58, 0.44)
    sun: Rgb = (0.557, -0.557, 0.616)


def noise(size: int, slope: float, seed: int, lowest: int = 1) -> Float:
    """Tileable noise (size, size), mean 0, standard deviation 1, amplitude ~ frequency^-slope."""
    rng = np.random.default_rng(seed)
    frequency = np.hypot(np.fft.fftfreq(size)[:, None], np.fft.rfftfreq(size)[None, :]) * size
    amplitude = np.where(frequency >= lowest, np.maximum(frequency, 1.0) ** -slope, 0.0)
    phase = np.exp(2j * np.pi * rng.random(amplitude.shape))
    field = np.fft.irfft2(amplitude * phase, s=(size, size))
    return (field / field.std()).astype(np.float32)


def blend(a: ArrayLike, b: ArrayLike, weight: NDArray) -> NDArray:
    """Colours (..., 3) between `a` (weight 0) and `b` (weight 1); weight (...)."""
    weight = np.asarray(weight)[..., None]
    return np.asarray(a, weight.dtype) * (1 - weight) + np.asarray(b, weight.dtype) * weight


def blend_to(color: NDArray, target: ArrayLike, weight: NDArray) -> NDArray:
    """Colours (..., 3) of `color` (..., 3) covered by `target` (3,) with weight (...)."""
    return color + (np.asarray(target, color.dtype) - color) * weight[..., None]


def sky_color(direction: NDArray, palette: Palette) -> NDArray:
    """Colours (..., 3) of the clear sky in unit directions (..., 3), NWU; below: far water."""
    up = direction[..., 2]
    above = blend(palette.horizon, palette.zenith, 1 - np.exp(-4.0 * np.maximum(up, 0)))
    glow = np.maximum(direction @ np.asarray(palette.sun, direction.dtype), 0)
    above = above + (0.22 * glow**6 + 0.6 * glow**180)[..., None] * np.array([1.0, 0.95, 0.8])
    below = blend(palette.horizon, palette.deep, 1 - np.exp(-14.0 * np.maximum(-up - 0.03, 0)))
    return np.clip(np.where(up[..., None] >= 0, above, below), 0, 1)


def _cube_directions(size: int) -> NDArray:
    """Unit directions (6, size, size, 3) of a skybox's texels in MuJoCo's face order."""
    line = (np.arange(size) + 0.5) / size * 2 - 1
    u, v = np.meshgrid(line, -line)
    one = np.ones_like(u)
    faces = [(one, u, v), (-one, -u, v), (u, v, one), (u, -v, -one), (u, -one, v), (-u, one, v)]
    directions = np.stack([np.stack(face, axis=-1) for face in faces])
    return directions / np.linalg.norm(directions, axis=-1, keepdims=True)


def sky_cube(palette: Palette, size: int = 384) -> Image:
    """Skybox texture (6 size, size, 3): gradient, sun, thin clouds that melt into the haze."""
    direction = _cube_directions(size)
    color = sky_color(direction, palette)
    tile = noise(512, 1.7, seed=3, lowest=2)
    # Clouds lie on a plane at unit height; their cover fades out towards the horizon.
    up = np.maximum(direction[..., 2], 0.03)
    index = [(direction[..., i] / up * 90).astype(int) % 512 for i in (0, 1)]
    cover = np.clip((tile[index[0], index[1]] - 0.2) * 0.55, 0, 0.75)
    cover = cover * np.clip((direction[..., 2] - 0.05) * 4, 0, 1)
    color = blend_to(color, (0.96, 0.97, 0.98), cover)
    return (np.clip(color, 0, 1) * 255 + 0.5).astype(np.uint8).reshape(6 * size, size, 3)


def sand(palette: Palette, size: int = 512) -> Image:
    """Seabed texture (size, size, 3): ripple marks, patches and grains; tileable."""
    patches, grains = noise(size, 1.6, seed=5), noise(size, 0.3, seed=6)
    line = np.arange(size) / size * 2 * np.pi
    marks = np.sin(26 * line[:, None] + 1.1 * noise(size, 2.2, seed=7))
    value = 0.82 + 0.10 * patches + 0.035 * grains + 0.06 * marks
    color = np.clip(value, 0.3, 1.25)[..., None] * np.asarray(palette.sand)
    return (np.clip(color, 0, 1) * 255).astype(np.uint8)


def ripple_slopes(size: int = 256) -> Float:
    """Tileable slopes (2, size, size) of wind ripples, root mean square 1 each."""
    height = np.fft.rfft2(noise(size, 2.6, seed=9, lowest=3))
    k = [np.fft.fftfreq(size)[:, None], np.fft.rfftfreq(size)[None, :]]
    slopes = np.stack([np.fft.irfft2(2j * np.pi * axis * height, s=(size, size)) for axis in k])
    return (slopes / slopes.std(axis=(1, 2), keepdims=True)).astype(np.float32)
