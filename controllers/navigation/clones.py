"""Measurements that arrive late: the filter remembers what it expected when they were taken.

A stochastic clone (Roumeliotis and Burdick 2002) of only what the measurement sees: at the sample
the predicted measurement `h(x)` is stored, and its error `y = H x` becomes further error states
with their full correlation to all others. Later predictions and corrections then carry it along;
when the data arrive, they are compared with it. The result is that of a filter which had waited.
"""

from dataclasses import replace

import numpy as np
from marine_mj.controllers.navigation.error_state import (
    ErrorState,
    ErrorStateFilter,
    Linear,
    transposed,
)
from marine_mj.controllers.navigation.kernels import CORE

from marine_mj import frames
from marine_mj.frames import Array


def products(a: Array, b: Array) -> Array:
    """Matrix products (..., m, k), row by row: the same bits alone or in a batch."""
    # columns of b one by one, as vectors
    return transposed(frames.apply(np.expand_dims(a, -3), transposed(b)))


def cloned(state: ErrorState, H: Array, place: int) -> ErrorState:
    """State whose error states `place ...` are the error `H x` of an expected measurement.

    Args:
        state: of the filter.
        H: (..., m, n), zero in the columns that are overwritten.
        place: first of the m error states.
    """
    stop = place + H.shape[-2]
    across = products(H, state.covariance)
    covariance = state.covariance.copy()
    covariance[..., place:stop, :] = across
    covariance[..., :, place:stop] = transposed(across)
    own = products(across, transposed(H))
    covariance[..., place:stop, place:stop] = 0.5 * (own + transposed(own))
    mean = state.mean.copy()
    mean[..., place + 1 : stop + 1] = 0.0
    return replace(state, mean=mean, covariance=covariance)


def late(
    kalman: ErrorStateFilter, state: ErrorState, residual: Array, R: Array, place: int
) -> Linear:
    """The measurement of a clone.

    Args:
        kalman, state: the filter.
        residual: (..., m) measurement minus what was expected at the sample.
        R: (..., m, m) of its noise.
        place: first error state of the clone.
    """
    m = residual.shape[-1]
    H = kalman.blank(state, m)
    H[..., place : place + m] = np.eye(m)
    first = place - CORE
    return Linear(residual - state.extra[..., first : first + m], H, R)
