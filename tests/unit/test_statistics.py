"""Intervals, fits and sensitivity against published values, closed forms and simulation."""

import re

import numpy as np
import pytest
from scipy import stats

from marine_mj.analysis import (
    bootstrap_interval,
    clopper_pearson_interval,
    cohens_d,
    convergence,
    fit_gamma,
    fit_normal,
    interval_width,
    main_effects,
    mean_interval,
    rank_regression,
    runs_needed,
    sobol_indices,
    statistics,
    wilson_interval,
)
from marine_mj.errors import AnalysisError


@pytest.mark.parametrize(
    ("k", "n", "wilson", "exact"),
    [  # Newcombe (1998), table I, to its four digits
        (81, 263, (0.2553, 0.3662), (0.2527, 0.3676)),
        (15, 148, (0.0624, 0.1605), (0.0578, 0.1617)),
        (0, 20, (0.0, 0.1611), (0.0, 0.1684)),
        (1, 29, (0.0061, 0.1718), (0.0009, 0.1776)),
    ],
)
def test_published_intervals(k, n, wilson, exact):
    np.testing.assert_allclose(wilson_interval(k, n), wilson, atol=5.1e-5)  # off by 4.9e-5
    np.testing.assert_allclose(clopper_pearson_interval(k, n), exact, atol=5.1e-5)


def test_intervals_at_the_ends_and_of_arrays():
    z2 = stats.norm.ppf(0.975) ** 2
    assert wilson_interval(0, 10)[0] == 0.0 and wilson_interval(10, 10)[1] == 1.0
    assert wilson_interval(0, 10)[1] == pytest.approx(z2 / (10 + z2), rel=1e-14)  # 0.27753
    assert clopper_pearson_interval(0, 10)[1] == pytest.approx(1 - 0.025**0.1, rel=1e-12)
    assert clopper_pearson_interval(10, 10)[1] == 1.0
    k = np.array([[0, 5], [991, 1000]])
    n = np.array([[10, 10], [1000, 1000]])
    for ours, method in ((wilson_interval, "wilson"), (clopper_pearson_interval, "exact")):
        low, high = ours(k, n, 0.9)
        for i in np.ndindex(k.shape):
            theirs = stats.binomtest(int(k[i]), int(n[i])).proportion_ci(0.9, method)
            # 2e-13 with SciPy's root finder
            np.testing.assert_allclose([low[i], high[i]], theirs, atol=1e-11)


@pytest.mark.parametrize("p", [0.01, 0.1, 0.5, 0.991])
def test_coverage_of_shares(p):
    """Exact coverage, summed over the binomial distribution."""
    n = 300
    k = np.arange(n + 1)
    weight = stats.binom.pmf(k, n, p)
    low, high = wilson_interval(k, n)
    # 0.943 to 0.967
    assert weight[(low <= p) & (p <= high)].sum() == pytest.approx(0.95, abs=0.02)
    low, high = clopper_pearson_interval(k, n)
    assert weight[(low <= p) & (p <= high)].sum() >= 0.95  # 0.957 to 0.989


def test_runs_needed_is_the_smallest_number():
    p = np.array([0.5, 0.991, 0.0, 1.0, 0.2])
    h = np.array([0.05, 0.005, 0.01, 0.01, 0.5])
    n = runs_needed(p, h)
    assert n.tolist() == [381, 1464, 189, 189, 1]
    assert (interval_width(p, n) <= 2 * h).all()
    assert (interval_width(p[:4], n[:4] - 1) > 2 * h[:4]).all()
    low, high = wilson_interval(81, 263)
    assert interval_width(81 / 263, 263) == pytest.approx(high - low, rel=1e-12)
    assert isinstance(runs_needed(0.5, 0.05), int)


def test_mean_interval():
    x = [4.0, 5.0, 6.0]
    # t(0.975, 2) = 4.302653 (tables), s = 1
    np.testing.assert_allclose(mean_interval(x), 5 + np.array([-1, 1]) * 4.302653 / 3**0.5)
    low, high = mean_interval(np.random.default_rng(1).normal(2.0, 3.0, (4000, 8)))
    assert ((low < 2) & (high > 2)).mean() == pytest.approx(0.95, abs=0.012)  # 0.952


def test_normal_fit(rng):
    x = rng.normal(-0.06, 0.195, (2000, 60))
    fit = fit_normal(x)
    assert fit.mean.mean() == pytest.approx(-0.06, abs=0.0023)  # 4 sigma; -0.0601
    # E s = c4 sigma, c4(60) = 0.99577: 0.19418; 0.1937, 4 sigma are 0.0016
    assert fit.std.mean() == pytest.approx(0.195 * 0.99577, abs=0.0016)
    one, theirs = fit_normal(x[3]), stats.norm(fit.mean[3], fit.std[3])
    assert isinstance(one.mean, float) and one.n == 60
    assert one.log_likelihood == pytest.approx(theirs.logpdf(x[3]).sum(), rel=1e-12)
    assert one.ks == pytest.approx(stats.kstest(x[3], theirs.cdf).statistic, rel=1e-12)
    # 99.7 % = mean +- 2.968 sigma, as the docking study has it
    ends = one.mean + np.array([-1, 1]) * 2.96774 * one.std
    np.testing.assert_allclose(one.interval(0.997), ends, rtol=1e-5)
    assert one.cdf(one.quantile(0.3)) == pytest.approx(0.3, rel=1e-12)


def test_gamma_fit(rng):
    x = rng.gamma(2.0, 3.5, (300, 1000))
    fit = fit_gamma(x)
    # 4 sigma of the mean of 300 fits with the bias of about 3 alpha / n; 2.009 and 3.492
    assert fit.shape.mean() == pytest.approx(2.006, abs=0.02)
    assert fit.scale.mean() == pytest.approx(3.5, abs=0.04)
    one = fit_gamma(x[0])
    shape, _, scale = stats.gamma.fit(x[0], floc=0)
    theirs = stats.gamma(shape, scale=scale)
    assert (one.shape, one.scale) == pytest.approx((shape, scale), rel=1e-9)  # 2e-16
    assert one.log_likelihood == pytest.approx(theirs.logpdf(x[0]).sum(), rel=1e-12)
    assert one.ks == pytest.approx(stats.kstest(x[0], theirs.cdf).statistic, rel=1e-9)
    assert one.interval(0.9) == pytest.approx(theirs.interval(0.9), rel=1e-9)
    assert one.quantile(0.997) == pytest.approx(theirs.ppf(0.997), rel=1e-9)


@pytest.mark.parametrize("shape", [0.05, 1.0, 1e3, 1e8])
def test_gamma_fit_solves_its_equation_for_any_shape(shape):
    x = np.random.default_rng(2).gamma(shape, 1.0, 400)
    fit = fit_gamma(x)
    # relative standard deviation of alpha is at most sqrt(2/400) = 7 %; off by at most 6.6 %
    assert fit.shape == pytest.approx(shape, rel=0.25)
    assert fit.shape * fit.scale == pytest.approx(x.mean(), rel=1e-12)
    eps = 1e-3 * fit.shape  # the likelihood is greatest here
    around = [stats.gamma(a, scale=x.mean() / a).logpdf(x).sum() for a in
              (fit.shape - eps, fit.shape, fit.shape + eps)]  # fmt: skip
    assert np.argmax(around) == 1


def test_goodness(rng):
    x = rng.normal(size=50)
    z = np.sort((x - x.mean()) / x.std(ddof=1))
    i = np.arange(1, 51)
    F = stats.norm.cdf(z)
    a2 = -50 - np.mean((2 * i - 1) * (np.log(F) + np.log(1 - F[::-1])))
    assert fit_normal(x).anderson_darling == pytest.approx(a2, rel=1e-12)
    # Stephens (1986): A^2 (1 + 0.75/n + 2.25/n^2) is above 0.752 in 5 % of normal samples
    many = fit_normal(rng.normal(size=(20000, 50))).anderson_darling
    share = (many * (1 + 0.75 / 50 + 2.25 / 2500) > 0.752).mean()
    assert share == pytest.approx(0.05, abs=0.006)  # 0.0498
    skewed = rng.gamma(1.5, 2.0, 200)
    assert fit_normal(skewed).p_value(199) == 1 / 200
    assert fit_gamma(skewed).p_value(199) > 0.05  # 0.155
    both = fit_gamma(rng.gamma(3.0, 1.0, (2, 40)))
    assert both.p_value(99).shape == (2,)
    assert both.p_value(99, seed=4).tolist() == both.p_value(99, seed=4).tolist()


def test_bca_covers_better_than_percentile():
    rng = np.random.default_rng(3)
    x = rng.exponential(size=(300, 30))
    covered = {}
    for method in ("bca", "percentile"):
        ends = [bootstrap_interval(v, resamples=499, method=method, vectorized=True) for v in x]
        covered[method] = np.mean([low < 1 < high for low, high in ends])
    # mean of 30 exponentials: known to stay below 0.95; 0.923 and 0.91
    assert covered["bca"] == pytest.approx(0.93, abs=0.05)
    assert covered["bca"] > covered["percentile"]


def test_bootstrap_of_rows_and_repeatability(rng):
    x = rng.normal(size=(40, 2)) @ [[1.0, 0.8], [0.0, 0.6]]

    def correlation(rows):
        return np.corrcoef(rows.T)[0, 1]

    low, high = bootstrap_interval(x, correlation, resamples=999, seed=4)
    assert (low, high) == bootstrap_interval(x, correlation, resamples=999, seed=4)
    # Fisher's transformation, (0.686, 0.902): off by 0.032 and 0.002
    center = np.arctanh(correlation(x))
    fisher = np.tanh(center + np.array([-1, 1]) * 1.96 / np.sqrt(37))
    np.testing.assert_allclose([low, high], fisher, atol=0.06)
    one = x[:, 0]
    assert bootstrap_interval(one, np.mean) == bootstrap_interval(one, np.mean, vectorized=True)
    assert bootstrap_interval(np.full(5, 3.0)) == (3.0, 3.0)


def test_cohens_d(rng):
    effect = cohens_d([2, 3, 4, 5, 6], [1, 2, 3, 4, 5])
    assert effect.d == pytest.approx(1 / np.sqrt(2.5), rel=1e-12)  # by hand
    # exact J(8) = Gamma(4) / (2 Gamma(3.5)) = 0.902703
    assert effect.g == pytest.approx(0.9027033 * effect.d, rel=1e-6)
    t = effect.d / np.sqrt(2 / 5)
    for end, p in ((effect.low, 0.975), (effect.high, 0.025)):  # off by 9e-9
        assert stats.nct.cdf(t, 8, end / np.sqrt(2 / 5)) == pytest.approx(p, abs=1e-6)
    many = cohens_d(rng.normal(0.5, 1, (2000, 20)), rng.normal(0, 1, (2000, 30)))
    covered = ((many.low < 0.5) & (many.high > 0.5)).mean()
    assert covered == pytest.approx(0.95, abs=0.015)  # 0.9455
    assert many.g.mean() == pytest.approx(0.5, abs=0.027)  # 4 sigma; 0.4904


def test_convergence(rng):
    x = rng.normal(1e6, 1, 200)
    run = convergence(x)
    assert run.n[0] == 2 and run.n[-1] == 200
    for i in (0, 50, 198):
        ends = mean_interval(x[: run.n[i]])
        np.testing.assert_allclose([run.low[i], run.high[i]], ends, rtol=1e-14)
    success = rng.uniform(size=100) < 0.9
    share = convergence(success, counts=[1, 10, 100])
    assert share.estimate.tolist() == [success[:n].mean() for n in (1, 10, 100)]
    assert (share.low[2], share.high[2]) == wilson_interval(int(success.sum()), 100)
    q = convergence(x, statistic=np.median, resamples=99)
    assert q.n[-1] == 200 and q.estimate[-1] == np.median(x)
    assert (q.low <= q.estimate).all() and (q.estimate <= q.high).all()


def ishigami(x):
    """Ishigami, Homma (1990), a = 7, b = 0.1."""
    return np.sin(x[:, 0]) + 7 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])


FIRST, TOTAL = (0.31391, 0.44241, 0.0), (0.55759, 0.44241, 0.24368)  # closed form


def test_sobol_indices():
    factors = [stats.uniform(-np.pi, 2 * np.pi)] * 3
    found = sobol_indices(ishigami, factors, 2048, resamples=99)
    np.testing.assert_allclose(found.first_order, FIRST, atol=0.01)  # 0.0022
    np.testing.assert_allclose(found.total, TOTAL, atol=0.01)  # 0.0009
    for value, (low, high) in ((FIRST, found.first_order_interval), (TOTAL, found.total_interval)):
        assert ((low < value) & (value < high)).all()
    assert found.evaluations == 2048 * 5
    again = sobol_indices(ishigami, factors, 2048, resamples=99)
    np.testing.assert_array_equal(again.total_interval, found.total_interval)


def test_sobol_points_of_unlike_factors():
    """Linear metric: shares are the variances, here 4 (normal) to 1 (uniform, 12 / 12)."""
    factors = [stats.norm(5, 2), stats.uniform(0, 12**0.5)]
    found = sobol_indices(lambda x: x.sum(axis=1), factors, 1024, resamples=9)
    np.testing.assert_allclose(found.first_order, [0.8, 0.2], atol=0.005)  # 0.0012
    np.testing.assert_allclose(found.total, [0.8, 0.2], atol=0.005)


def test_main_effects(rng):
    x = rng.uniform(-np.pi, np.pi, (20000, 3))
    found = main_effects(x, ishigami(x), groups=40)
    np.testing.assert_allclose(found.first_order, FIRST, atol=0.02)  # 0.0039
    assert found.p_value[0] < 1e-12 and found.p_value[2] > 0.01
    # no effect: eta^2 is (g - 1) / (n - 1) by chance, the corrected one 0, p uniform
    noise = [main_effects(rng.normal(size=(60, 1)), rng.normal(size=60), 6) for _ in range(400)]
    ratio, corrected, p = (np.array([getattr(e, a)[0] for e in noise]) for a in
                           ("correlation_ratio", "first_order", "p_value"))  # fmt: skip
    assert ratio.mean() == pytest.approx(5 / 59, abs=0.011)  # 4 sigma; 0.0879
    assert corrected.mean() == pytest.approx(0, abs=0.012)  # 0.0035
    assert stats.kstest(p, "uniform").pvalue > 0.01  # 0.63
    groups = main_effects(np.array([[1, 1, 2, 2, 3, 3.0]]).T, np.arange(6.0), 3)
    assert groups.levels[0].tolist() == [1, 2, 3] and groups.means[0].tolist() == [0.5, 2.5, 4.5]
    assert groups.correlation_ratio[0] == pytest.approx(16 / 17.5)  # by hand


def test_main_effects_match_the_analysis_of_variance(rng):
    y = rng.normal(size=30)
    factor = np.repeat([0.0, 1.0, 2.0], 10)
    theirs = stats.f_oneway(y[:10], y[10:20], y[20:])
    ours = main_effects(factor[:, None], y, 3)
    assert ours.p_value[0] == pytest.approx(theirs.pvalue, rel=1e-10)


def test_rank_regression(rng):
    x = rng.normal(size=(500, 3))
    found = rank_regression(x, np.exp(x[:, 0] - 0.5 * x[:, 1]))
    assert found.r2 > 0.95  # 0.97; monotone, though not linear
    assert found.coefficients[0] > 0.8 and -0.5 < found.coefficients[1] < -0.35
    assert found.low[2] < 0 < found.high[2]
    single = rank_regression(x[:, :1], x[:, 0] + x[:, 1])  # one factor: Spearman's rho
    rho = stats.spearmanr(x[:, 0], x[:, 0] + x[:, 1]).statistic
    assert single.coefficients[0] == pytest.approx(rho, rel=1e-12)


NAN = [1.0, np.nan, 2.0]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: wilson_interval(1, 0), "n is 0, allowed are whole numbers >= 1: run something"),
        (lambda: wilson_interval(3, 2), "successes is 3, allowed are whole numbers from 0 to n ="),
        (lambda: wilson_interval(0.5, 2), "successes is 0.5, allowed are whole numbers"),
        (lambda: wilson_interval(1, 2, 95), "confidence is 95, allowed is > 0 and < 1"),
        (lambda: runs_needed(1.2, 0.1), "p is 1.2, allowed is >= 0 and <= 1: write 95 % as 0.95"),
        (lambda: runs_needed(0.5, 0), "half_width is 0, allowed is > 0, finite: write +-5 % as"),
        (lambda: interval_width(0.5, -1), "n is -1, allowed is > 0, finite: give the number of"),
        (lambda: mean_interval(NAN), "x has 1 NaN or infinite of 3 values, allowed are finite"),
        (lambda: mean_interval([1]), "x has 1 values, allowed are 2 or more: run more"),
        (lambda: mean_interval(1.0), "x has 0 dimensions, allowed are 1 or more: reshape it"),
        (lambda: mean_interval(["a", "b"]), "x is not an array of numbers"),
        (lambda: fit_normal([2, 2]), "all values of x are 2, allowed are samples that differ"),
        (lambda: fit_gamma([[1, 2], [3, 3]]), "all values of x are 3, allowed are samples that"),
        (lambda: fit_gamma([1, 0]), "x has the value 0, allowed is > 0 for a gamma distribution"),
        (lambda: fit_gamma([1, 1 + 2e-16]), "the values of x differ by 2e-16 of their mean,"),
        (lambda: fit_normal([1, 2]).quantile(1), "p is 1, allowed is > 0 and < 1"),
        (lambda: fit_normal([1, 2]).interval(0), "coverage is 0, allowed is > 0 and < 1"),
        (lambda: fit_normal([1, 2]).p_value(0), "resamples is 0, allowed are whole numbers >= 1"),
        (lambda: cohens_d([1, 1], [2, 2]), "pooled standard deviation of a and b is 0"),
        (lambda: bootstrap_interval([1, 2], method="t"), "method is 't', allowed are bca, percent"),
        (lambda: bootstrap_interval([1, 2], seed=-1), "seed is -1, allowed are whole numbers >= 0"),
        (lambda: bootstrap_interval(1.0), "x has 0 dimensions, allowed are 1 or more"),
        (lambda: bootstrap_interval([[1, 2]]), "x has 1 values, allowed are 2 or more"),
        (lambda: bootstrap_interval(NAN), "x has 1 NaN or infinite of 3 values"),
        (lambda: bootstrap_interval([1, 2], lambda x: np.nan), "statistic is NaN or infinite in 9"),
        (lambda: bootstrap_interval([1, 2, 3, 4, 5], lambda x: float(x.mean() > 3.5)),
         "the statistic does not change when one run is left out, allowed is 'percentile'"),
        (lambda: bootstrap_interval(np.eye(3), vectorized=True), "x has 2 dimensions, allowed is"),
        (lambda: convergence([1.0, 2, 3], [3, 2]), "counts is [3, 2], allowed are ascending whole"),
        (lambda: main_effects(np.eye(3), [1, 2]), "factors has shape (3, 3), allowed is (2, k)"),
        (lambda: main_effects(np.ones((4, 1)), range(4), 2), "factors[:, 0] is 1 in all runs"),
        (lambda: main_effects(np.eye(4), [1] * 4, 2), "metric is 1 in all runs"),
        (lambda: main_effects(np.eye(3), [1, 2, 3], 2), "metric has 3 runs, allowed are 4 or more"),
        (lambda: rank_regression(np.eye(3), [1, 2, 3]), "metric has 3 runs, allowed are 5 or more"),
        (lambda: rank_regression(np.outer(range(6), [1, 2]), range(6)),
         "a factor follows from the ranks of the others"),
        (lambda: sobol_indices(ishigami, [], 8), "distributions is empty, allowed is one or"),
        (lambda: sobol_indices(ishigami, [], 12), "n is 12, allowed are powers of 2: take 16"),
        (lambda: sobol_indices(lambda x: x, [stats.norm()], 4), "function gave the shape (12, 1)"),
        (lambda: sobol_indices(lambda x: 0 * x[:, 0], [stats.norm()], 4), "same value in all runs"),
        (lambda: sobol_indices(lambda x: x[:, 0] / 0, [stats.norm()], 4), "function has 12 NaN or"),
    ],
)  # fmt: skip
def test_refusals(call, message):
    with np.errstate(all="ignore"), pytest.raises(AnalysisError, match=re.escape(message)):
        call()


def test_names_that_campaigns_use():
    names = ("wilson_interval", "fit_normal", "fit_gamma", "bootstrap_interval")
    assert set(names) <= set(statistics.__all__)
