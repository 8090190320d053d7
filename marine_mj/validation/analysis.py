"""Statistics cases: rare events and sensitivity beside their closed forms."""

from collections.abc import Iterator

import numpy as np
from scipy import stats

from marine_mj.analysis import (
    main_effects,
    multilevel_splitting,
    pool,
    sobol_indices,
    subset_simulation,
    wilson_interval,
)
from marine_mj.environment import gaussian_sea, jonswap
from marine_mj.frames import Array
from marine_mj.validation.rows import Row, row


def shares() -> Iterator[Row]:
    """Wilson's interval beside the published one."""
    source = "Newcombe 1998, table I"
    for end, ours, published in zip(
        ("lower", "upper"), wilson_interval(81, 263), (0.2553, 0.3662), strict=True
    ):
        yield row(f"Wilson, 81 of 263, {end} end", ours, published, "1", source, within=5.1e-5)


def limit_state() -> Iterator[Row]:
    """Subset simulation of a plane at beta 3.5, 400 repetitions for each dimension."""
    exact = stats.norm.sf(3.5)
    for d in (2, 20, 200):
        name = f"subset simulation, plane in {d} dimensions"

        def plane(u: Array, scale: float = 1 / np.sqrt(d)) -> Array:
            """Distance along the diagonal."""
            return scale * u.sum(axis=1)

        found = [subset_simulation(plane, d, 3.5, seed=i) for i in range(400)]
        p, cov = (np.array([getattr(e, a) for e in found]) for a in ("probability", "cov"))
        scatter = p.std(ddof=1) / exact
        ends = np.array([e.interval() for e in found])
        covered = ((ends[:, 0] < exact) & (exact < ends[:, 1])).mean()
        # 4 standard errors of 400 runs
        yield row(f"{name}, mean / p", p.mean() / exact, 1, "1", "Phi(-3.5)", within=scatter / 5)
        reported = np.sqrt((cov**2).mean())
        yield row(
            f"{name}, reported cov / scatter", reported / scatter, 1, "1", "scatter", within=0.2
        )
        yield row(f"{name}, coverage of 95 %", covered, 0.95, "1", "Phi(-3.5)", within=0.05)


def rare_crest() -> Iterator[Row]:
    """Elevation and envelope at one instant, searched in the space of narrow-band seas."""
    sea = jonswap(2.0, 8.0)
    peak = 2 * np.pi / sea.T_p
    seas = [
        gaussian_sea(u, spectrum=sea, frequency_range=(0.9 * peak, 1.1 * peak)) for u in np.eye(40)
    ]
    # The sea is linear in u: phasors at x = 10 m, t = 5 s of the unit vectors.
    phasor = np.array([(s.phasors(10, 0) * np.exp(-5j * s.omega)).sum() for s in seas])
    sigma = float(np.linalg.norm(phasor.real))
    for name, score, a, p, source in (
        ("elevation > 4 sqrt(m0)", lambda u: u @ phasor.real, 4.0, stats.norm.sf(4.0), "Phi(-4)"),
        ("envelope > 4.6 sqrt(m0)", lambda u: np.abs(u @ phasor), 4.6, np.exp(-(4.6**2) / 2),
         "Rayleigh, exp(-a^2 / 2 m0)"),
    ):  # fmt: skip
        found = pool([subset_simulation(score, 40, a * sigma, seed=i) for i in range(200)])
        ratio = found.probability / p
        yield row(f"narrow-band sea, P({name}) / p", ratio, 1, "1", source, within=4 * found.cov)


def splitting() -> Iterator[Row]:
    """Largest value of a random walk by multilevel splitting."""

    def walk(states: Array, rng: np.random.Generator) -> tuple[Array, Array]:
        """One step of +-1."""
        states = states + 2 * rng.integers(0, 2, states.shape) - 1
        return states, states[:, 0]

    n, b = 100, 40
    p = stats.binom.sf((n + b) // 2 - 1, n, 0.5) + stats.binom.sf((n + b) // 2, n, 0.5)
    found = [multilevel_splitting(walk, [[0]], [14, 22, 28, 34, b], n, seed=i) for i in range(100)]
    ratio = np.array([e.probability for e in found]) / p
    yield row("multilevel splitting, random walk, mean / p", ratio.mean(), 1, "1",
              "reflection principle", within=0.4 * ratio.std(ddof=1))  # fmt: skip


def sensitivity() -> Iterator[Row]:
    """Sobol indices of the Ishigami function, designed and from given data."""

    def ishigami(x: Array) -> Array:
        """Metric of three factors."""
        return np.sin(x[:, 0]) + 7 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])

    first, total = np.array([0.31391, 0.44241, 0.0]), np.array([0.55759, 0.44241, 0.24368])
    found = sobol_indices(ishigami, [stats.uniform(-np.pi, 2 * np.pi)] * 3, 4096, resamples=1)
    x = np.random.default_rng(0).uniform(-np.pi, np.pi, (20000, 3))
    given = main_effects(x, ishigami(x), 40).first_order
    for name, ours, exact in (
        ("Sobol, first order", found.first_order, first),
        ("Sobol, total", found.total, total),
        ("main effects of given data", given, first),
    ):
        error = np.abs(ours - exact).max()
        yield row(f"{name}, largest error", error, 0, "1", "Ishigami, closed form", within=0.02)


CASES = (shares, limit_state, rare_crest, splitting, sensitivity)
