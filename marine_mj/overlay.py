"""Small text and insets on frames."""

import functools
import re
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from marine_mj.water import Components

Frame = NDArray[np.uint8]
#: Lines of text at a time (s) of the run.
Overlay = Callable[[float], Sequence[str]]


#: Height of text as part of the picture's height, and its least height in pixels.
_TEXT, _LEAST = 1 / 40, 13


@functools.lru_cache(maxsize=32)
def _patch(lines: tuple[str, ...], size: int) -> tuple[NDArray, NDArray]:
    """Brightness and cover (h, w, 1) in [0, 1] of lines of text with a soft dark edge."""
    font = ImageFont.load_default(size)
    step = round(1.45 * size)
    width = int(max((font.getlength(line) for line in lines), default=1)) + 8
    image = Image.new("L", (width, step * len(lines) + 6))
    draw = ImageDraw.Draw(image)
    for row, line in enumerate(lines):
        draw.text((3, 2 + row * step), line, fill=255, font=font)
    text = np.asarray(image, np.float32) / 255
    shadow = np.maximum.reduce(
        [np.roll(text, (i, j), (0, 1)) for i in (-1, 0, 1) for j in (-1, 0, 1)]
    )
    return text[..., None], np.maximum(text, 0.55 * shadow)[..., None]


def write_lines(
    frame: Frame, lines: Sequence[str], scale: float = 1.0, right: bool = False
) -> None:
    """Write lines of text into the upper left (or right) corner of a frame, in place."""
    if not lines:
        return
    size = round(scale * max(_TEXT * frame.shape[0], _LEAST))
    text, cover = _patch(tuple(lines), size)
    margin = round(0.018 * frame.shape[1])
    left = max(frame.shape[1] - margin - text.shape[1], 0) if right else margin
    part = frame[margin : margin + text.shape[0], left : left + text.shape[1]]
    text, cover = text[: part.shape[0], : part.shape[1]], cover[: part.shape[0], : part.shape[1]]
    part[:] = (part * (1 - cover) + 250 * text * cover).astype(np.uint8)


def frame_inset(picture: Frame, inset: Frame, top: int, right: int) -> None:
    """Put `inset` into `picture`, `top` and `right` pixels from its edges, with a thin border."""
    height, width = inset.shape[:2]
    left = picture.shape[1] - right - width
    picture[top - 1 : top + height + 1, left - 1 : left + width + 1] = (225, 232, 235)
    picture[top : top + height, left : left + width] = inset


def log_overlay(data: Any, waves: Components, title: str = "") -> Overlay:
    """Lines from a log: time, sea, and for docking the phase and the error in the dock frame.

    Args:
        data: dataset of the log.
        waves: of the run.
        title: first line; none if empty.
    """
    time = np.asarray(data["time"], float)
    sea = describe_sea(waves)
    error = np.asarray(data["dock_error"], float) if "dock_error" in data else None
    phase = np.asarray(data["phase"], float) if "phase" in data else None
    names = phase_names(data)
    latched = np.asarray(data["latched"]) if "latched" in data else None

    def lines(now: float) -> list[str]:
        i = int(np.clip(np.searchsorted(time, now + 1e-9, side="right") - 1, 0, len(time) - 1))
        result = [title, f"t = {now:5.1f} s", sea]
        if error is not None and error.ndim == 2:
            distance = np.linalg.norm(error[i, : min(3, error.shape[1])])
            angle = np.rad2deg(np.linalg.norm(error[i, 3:6]))
            result.append(f"way to dock {distance:5.2f} m, {angle:4.1f} deg")
        if latched is not None and latched[i] > 0.5:
            result.append("latched")
        elif phase is not None:
            result.append(phase_label(float(phase[i]), names))
        return [line for line in result if line]

    return lines


def phase_names(data: Any) -> dict[int, str]:
    """Names of a log's phases, from a text attribute of `phase` like "0 approach 1 under"."""
    if "phase" not in data:
        return {}
    for text in data["phase"].attrs.values():
        names = re.findall(r"(\d+)\s+([a-z][a-z ]*?)\s*(?=\d|$)", str(text))
        if len(names) > 1:
            return {int(number): name for number, name in names}
    return {}


def phase_label(value: float, names: dict[int, str]) -> str:
    """Name of a phase; its number if it has no name; nothing where there is no phase (NaN)."""
    if not np.isfinite(value):
        return ""
    return names.get(int(value), f"phase {int(value)}")


def describe_sea(waves: Components) -> str:
    """One line on the sea: significant height and peak period, or a regular wave, or calm."""
    amplitude = np.asarray(waves.amplitude)
    if not np.any(amplitude > 0):
        return "calm"
    strongest = int(np.argmax(amplitude))
    period = 2 * np.pi / np.asarray(waves.omega)[strongest]
    if np.count_nonzero(amplitude) == 1:
        return f"wave H = {2 * amplitude[strongest]:.2f} m, T = {period:.1f} s"
    height = 4 * np.sqrt(0.5 * np.sum(amplitude**2))
    return f"sea H_s = {height:.2f} m, T_p = {period:.1f} s"
