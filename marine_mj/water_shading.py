"""Colour of the water sheet: what its two sides send towards a camera.

From above: Schlick's form of Fresnel reflection of the sky, weakened at grazing angles because a
rough sea shows its facets (after Bruneton, Neyret, Holzschuch 2010), over the colour of the deep
water, greener in crests, with foam on the highest ones and haze with distance. From below: bright
sky inside Snell's window (48.6 degrees from the vertical), the dark water mirrored outside.
"""

import numpy as np
from numpy.typing import NDArray

from marine_mj.textures import Palette, noise, ripple_slopes, sky_color

Float = NDArray[np.float32]

#: Refractive index of sea water, and the cosine of its critical angle.
INDEX = 1.34
COS_CRITICAL = float(np.sqrt(1 - INDEX**-2))
#: Side of the ripple tile in m; root mean square slope of the ripples.
TILE, RIPPLE = 7.0, 0.085
#: Distance over which water seen from above fades into the haze, m.
HAZE = 420.0


def ramp(value: Float, start: float, stop: float) -> Float:
    """0 below `start`, 1 above `stop`, linear between."""
    return np.clip((value - start) * (1.0 / (stop - start)), 0, 1)


class Shader:
    """Colours of the sheet's texels, for a grid that is fixed relative to its centre.

    Args:
        axis: texel coordinates (n,) along one axis relative to the sheet's centre, m.
        palette: colours.
        significant_height: of the sea, m.
    """

    def __init__(self, axis: NDArray, palette: Palette, significant_height: float) -> None:
        self.axis, self.palette = axis, palette
        self.height = significant_height
        self._tiles = ripple_slopes()
        self._foam_tile = noise(256, 1.1, seed=12, lowest=3)
        # Ripples exist where texels can show them, and under any wind worth the name.
        fade = np.clip(1.3 - np.gradient(axis) / 0.8, 0.0, 1.0)
        rough = RIPPLE * np.clip(0.35 + self.height, 0.35, 1.0)
        self._fade = (rough * fade[:, None] * fade[None, :]).astype(np.float32)
        # Further out, where cells carry only the long waves, broader ripples stand for the rest.
        spacing = np.gradient(axis)
        near = np.clip((spacing - 0.15) / 0.6, 0, 1)
        far = np.clip(1.6 - spacing / 14.0, 0, 1)
        broad = far[:, None] * far[None, :] * np.maximum(near[:, None], near[None, :])
        self._broad = (min(0.055 * self.height, 0.11) * broad).astype(np.float32)
        # Coarse texels would turn glitter into blotches.
        self._sharp = (0.15 + 0.85 * fade[:, None] * fade[None, :]).astype(np.float32)
        # The sky that a facet mirrors depends on its elevation only: one table.
        up = np.linspace(0, 1, 256)
        side = np.stack([np.sqrt(1 - up**2), 0 * up, up], -1)
        self._sky = sky_color(side, palette).astype(np.float32)
        self.move(np.zeros(2))

    def move(self, center: NDArray) -> None:
        """Keep ripples and foam where they are in the world when the sheet's centre moves."""
        self._world = [(self.axis + value).astype(np.float64) for value in center]

    def _tile(self, tile: NDArray, scale: float, drift: tuple[float, float]) -> Float:
        """A tile (256, 256) laid over the texels; `scale` tiles a TILE, drifted by m."""
        rows, columns = (
            (((axis - shift) * (256 * scale / TILE)).astype(np.int64)) & 255
            for axis, shift in zip(self._world, drift, strict=True)
        )
        return tile[rows[:, None], columns[None, :]]

    def _normals(self, slope: tuple[Float, Float], time: float) -> tuple[Float, Float, Float]:
        """Unit normals (upwards) of waves plus three drifting layers of ripples."""
        drifts = ((0.45 * time, 0.25 * time), (-0.2 * time, 0.5 * time))
        s = [
            slope[i]
            + self._broad * self._tile(self._tiles[i], 0.075, (1.5 * time, 0.8 * time))
            + self._fade
            * (
                self._tile(self._tiles[i], 1.0, drifts[0])
                + self._tile(self._tiles[1 - i], 0.43, drifts[1])
            )
            for i in (0, 1)
        ]
        up = 1 / np.sqrt(1 + s[0] * s[0] + s[1] * s[1])
        return -s[0] * up, -s[1] * up, up

    def __call__(
        self,
        elevation: Float,
        slope: tuple[Float, Float],
        camera: NDArray,
        time: float,
        under: bool,
    ) -> NDArray[np.uint8]:
        """Colours (n, n, 3) as seen from `camera` (3,), relative to the sheet's centre, m."""
        offset = camera.astype(np.float32)
        x = (offset[0] - self.axis.astype(np.float32))[:, None]
        y = (offset[1] - self.axis.astype(np.float32))[None, :]
        z = offset[2] - elevation
        distance = np.sqrt(x * x + y * y + z * z) + np.float32(1e-3)
        nx, ny, nz = self._normals(slope, time)
        facing = (nx * x + ny * y + nz * z) / distance
        if under:
            color = self._from_below(nz, -facing, z / distance)
        else:
            color = self._from_above((x, y, z), distance, (nx, ny, nz), facing, elevation)
        np.clip(color, 0, 1, out=color)
        color *= 255
        return color.astype(np.uint8)

    def _from_above(
        self,
        ray: tuple[Float, Float, Float],
        distance: Float,
        normal: tuple[Float, Float, Float],
        facing: Float,
        elevation: Float,
    ) -> Float:
        palette = self.palette
        facing = np.maximum(facing, 0.0)
        reflected = [2 * facing * n - r / distance for n, r in zip(normal, ray, strict=True)]
        sky = self._sky[(np.clip(reflected[2], 0.02, 1) * 255).astype(np.uint8)]
        mirror = 0.02 + 0.55 * (1 - facing) ** 4
        # Light through the water: more where a crest is thin, and where a wave leans away.
        height = max(self.height, 0.2)
        crest = np.clip(0.30 + 0.75 * elevation / height, 0, 1) * (1.15 - 0.6 * normal[2] * facing)
        deep, scatter = (np.array(c, np.float32) for c in (palette.deep, palette.scatter))
        color = deep + (scatter - deep) * np.clip(crest, 0, 1)[..., None]
        color += (sky - color) * mirror[..., None]
        sun = sum(r * s for r, s in zip(reflected, palette.sun, strict=True))
        glitter = np.maximum(sun, 0) ** 90
        color += (0.55 * glitter * self._sharp)[..., None] * np.array([1.0, 0.96, 0.86], np.float32)
        if self.height > 0.6:
            foam = self._foam(elevation)
            color += (np.array(palette.foam, np.float32) - color) * foam[..., None]
        haze = 1 - np.exp(distance * (-1 / HAZE))
        color += (np.array(palette.horizon, np.float32) - color) * haze[..., None]
        return color

    def _foam(self, elevation: Float) -> Float:
        """Cover (n, n) of foam: streaky, on crests above half the significant height."""
        pattern = self._tile(self._foam_tile, 0.8, (0, 0)) * 0.5 + self._tile(
            self._foam_tile, 0.21, (0, 0)
        )
        return 0.75 * ramp(elevation / self.height + 0.13 * pattern, 0.6, 0.9)

    def _from_below(self, nz: Float, facing: Float, down: Float) -> Float:
        """`facing`: cosine between the surface's normal and the ray towards the camera."""
        palette = self.palette
        window = ramp(np.maximum(facing, 0), COS_CRITICAL - 0.04, COS_CRITICAL + 0.16)
        # Outside the window the facet mirrors water: darker the more it looks down.
        mirror = np.clip(1.25 - 0.5 * np.abs(2 * facing * nz + down), 0.55, 1.25)
        dark, bright = (np.array(c, np.float32) for c in (palette.underside, palette.window))
        color = dark * mirror[..., None]
        color += (bright - color) * (0.9 * window)[..., None]
        glint = ramp(facing, 0.93, 1.0)
        color += (0.25 * glint)[..., None]
        return color
