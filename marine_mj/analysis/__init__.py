"""Statistics of Monte Carlo studies and rare events (NumPy and SciPy only)."""

from marine_mj.analysis.distributions import GammaFit, NormalFit, fit_gamma, fit_normal
from marine_mj.analysis.proportions import (
    clopper_pearson_interval,
    interval_width,
    runs_needed,
    wilson_interval,
)
from marine_mj.analysis.rare import RareEventEstimate, crude_monte_carlo, pool
from marine_mj.analysis.sensitivity import (
    MainEffects,
    RankRegression,
    SobolIndices,
    main_effects,
    rank_regression,
    sobol_indices,
)
from marine_mj.analysis.splitting import multilevel_splitting
from marine_mj.analysis.statistics import (
    Convergence,
    EffectSize,
    bootstrap_interval,
    cohens_d,
    convergence,
    mean_interval,
)
from marine_mj.analysis.subset import SubsetState, subset_simulation

__all__ = [
    "Convergence",
    "EffectSize",
    "GammaFit",
    "MainEffects",
    "NormalFit",
    "RankRegression",
    "RareEventEstimate",
    "SobolIndices",
    "SubsetState",
    "bootstrap_interval",
    "clopper_pearson_interval",
    "cohens_d",
    "convergence",
    "crude_monte_carlo",
    "fit_gamma",
    "fit_normal",
    "interval_width",
    "main_effects",
    "mean_interval",
    "multilevel_splitting",
    "pool",
    "rank_regression",
    "runs_needed",
    "sobol_indices",
    "subset_simulation",
    "wilson_interval",
]
