"""Campaign files: what is refused and how, distributions, conditions, runs and seeds."""

import numpy as np
import pytest
from campaign_helpers import CALM, plan
from scipy import stats

from marine_mj.campaign import Campaign, Plan
from marine_mj.campaign.conditions import Condition, look_up, transformed
from marine_mj.campaign.distributions import quantile
from marine_mj.errors import CampaignError, ModelError, ScenarioError

BASE = 'name = "t"\nscenario = "docking_demo"\nruns = 2\n'


@pytest.mark.parametrize("name", Campaign.packaged())
def test_packaged_campaigns_are_valid_and_survive_the_round_trip(name):
    campaign = Campaign.load(name)
    assert Campaign.from_toml(campaign.to_toml()) == campaign
    assert Plan(campaign).total == Plan(campaign).cells * (campaign.runs or 0)


@pytest.mark.parametrize(
    ("addition", "message"),
    [
        ("run = 3", r"run = 3: unknown key 'run'. Did you mean 'runs'\?"),
        ("chunk = 0", r"chunk = 0: .*greater than or equal to 1"),
        ("seed = -1", r"seed = -1: .*greater than or equal to 0"),
        ('success = ["docked"]', r"'docked' is not of the form KEY SIGN VALUE"),
        ('success = ["a < true"]', r"true cannot be compared by <"),
        ('success = ["a == [1]"]', r"\[1\] cannot be compared by =="),
        ('success = ["a < nan"]', r"allowed are finite numbers"),
        ('[factors.a]\nkey = "seed"\ngrid = [1]', "'seed' of factor 'a' is set by the campaign's"),
        ('[factors.run]\nkey = "x"\ngrid = [1]', "column 'run' is not allowed"),
        ('[factors."a b"]\nkey = "x"\ngrid = [1]', "column 'a b' is not allowed"),
        ('[factors.a]\nkey = "x"', "exactly one of grid, cases and distribution; given: none"),
        (
            '[factors.a]\nkey = "x"\ngrid = [1]\ndistribution = "uniform"',
            "given: grid, distribution",
        ),
        ("[factors.a]\ngrid = [1]", "grid and distribution need a key"),
        ('[factors.a]\nkey = "x"\ngrid = [1, 1]', "values stand twice: 1, 1"),
        ('[factors.a]\nkey = "x y"\ngrid = [1]', "key = 'x y' is not a dotted key"),
        ('[factors.a]\nkey = "x"\ngrid = []', r"factors\.a\.grid = \[\]: .*at least 1 item"),
        (
            '[factors.a]\nkey = "x"\ngrid = [1]\nsampling = "latin_hypercube"',
            "parameters and sampling belong to a distribution",
        ),
        (
            '[factors.a]\nkey = "x"\ngrid = [1]\n[factors.b]\nkey = "x"\ngrid = [1]',
            "key 'x' of factor 'b' is set by factor 'a' too",
        ),
        (
            '[factors.a]\nkey = "x"\ndistribution = "gauss"',
            "distribution 'gauss' does not exist; there are uniform, normal",
        ),
        (
            '[factors.a]\nkey = "x"\ndistribution = "uniform"\nparameters = { low = 1 }',
            "takes the parameters low, high; given: low = 1",
        ),
        (
            '[factors.a]\nkey = "x"\ndistribution = "uniform"\nparameters = {low = 2, high = 1}',
            "has no values with the parameters low = 2, high = 1",
        ),
        (
            '[factors.a]\nkey = "x"\ndistribution = "normal"\nparameters = {mean = 2, std = "a"}',
            "parameter std = 'a' is not a finite number",
        ),
        (
            '[factors.a]\nkey = "x"\ndistribution = "choice"\n'
            "parameters = { values = [1, 2], weights = [1] }",
            r"weights = \[1\] must be 2 numbers >= 0",
        ),
        (
            '[factors.a]\nkey = "x"\ndistribution = "weibull_min"\nparameters = { k = 2 }',
            r"'weibull_min' \(scipy.stats\), given k = 2: .*unexpected keyword",
        ),
        ('[factors.m]\nkey = "x"\ngrid = [1]\n[metrics]\nm = "y"', "m is the name of a factor and"),
        ('[metrics]\nm = { key = "y", transform = "log" }', "transform 'log' does not exist; abs"),
        ('[stopping]\nmetric = "m"\nwidth = 0.1', "stopping.metric = 'm' does not exist; there"),
        ("[stopping]\nwidth = 0.1\nevery = 15", "every = 15 must be a multiple of chunk = 10"),
        ("[stopping]\nwidth = -0.1", r"stopping\.width = -0\.1: .*greater than 0"),
    ],
)
def test_bad_campaigns_say_what_is_wrong(addition, message):
    with pytest.raises(ScenarioError, match=message):
        Campaign.from_toml(BASE + addition)


def test_bad_files_names_and_keys(tmp_path):
    with pytest.raises(ScenarioError, match="neither a file nor a packaged campaign; packaged: d"):
        Campaign.load("nothing")
    with pytest.raises(ScenarioError, match="is not valid TOML"):
        Campaign.from_toml("name = ")
    with pytest.raises(ScenarioError, match="name = 'a/b' is not allowed"):
        Campaign.from_toml(BASE.replace('"t"', '"a/b"'))
    with pytest.raises(ScenarioError, match=r"unknown key 'sea_stat'\. Did you mean 'sea_state'"):
        Plan(Campaign.from_toml(BASE + '[factors.a]\nkey = "sea.sea_stat"\ngrid = [1]'))
    with pytest.raises(ScenarioError, match=r"position_ned\[3\]': the scenario's .* not a vector"):
        Plan(
            Campaign.from_toml(
                BASE + '[factors.a]\nkey = "vehicles.auv.position_ned[3]"\ngrid = [1.0]'
            )
        )


def test_check_builds_every_level_before_anything_runs():
    text = BASE + '[factors.a]\nkey = "task.settings.gains"\ngrid = ["extended", "best"]'
    with pytest.raises(ScenarioError, match=r"a = 'best': task.settings.*gains"):
        Plan(Campaign.from_toml(text)).check()
    text = BASE + '[factors.a]\nkey = "vehicles.auv.model"\ngrid = ["scout", "titanic"]'
    with pytest.raises(ModelError, match=r"a = 'titanic': unknown vehicle 'titanic'"):
        Plan(Campaign.from_toml(text)).check()
    text = BASE + '[record]\nsignals = ["eta"]'
    with pytest.raises(ScenarioError, match=r"'eta' does not exist; there are qpos, .*phase"):
        Plan(Campaign.from_toml(text)).check()


def test_scenario_beside_the_campaign_file_is_found(tmp_path):
    from marine_mj.scenario import Scenario

    (tmp_path / "mine.toml").write_text(Scenario.load("docking_demo").to_toml())
    (tmp_path / "c.toml").write_text(BASE.replace("docking_demo", "mine.toml"))
    assert Plan.load(tmp_path / "c.toml").base == Scenario.load("docking_demo")


@pytest.mark.parametrize(
    ("name", "parameters", "same"),
    [
        ("uniform", {"low": -2.0, "high": 3.0}, stats.uniform(-2, 5)),
        ("normal", {"mean": 1.0, "std": 2.0}, stats.norm(1, 2)),
        (
            "truncated_normal",
            {"mean": 1.0, "std": 2.0, "low": 0.0, "high": 2.0},
            stats.truncnorm(-0.5, 0.5, 1, 2),
        ),
        ("lognormal", {"median": 3.0, "sigma": 0.5}, stats.lognorm(0.5, scale=3)),
        ("gamma", {"shape": 2.0, "scale": 0.5}, stats.gamma(2, scale=0.5)),
        ("integers", {"low": 2, "high": 5}, stats.randint(2, 6)),
        ("weibull_min", {"c": 1.5, "scale": 2.0}, stats.weibull_min(1.5, scale=2)),
        ("poisson", {"mu": 4}, stats.poisson(4)),
    ],
)
def test_distributions_are_those_of_scipy(name, parameters, same):
    units = (np.arange(500) + 0.5) / 500
    draw = quantile(name, parameters)
    values = np.array([draw(u) for u in units])
    # Midpoint quantiles miss only the tails: measured 0 (symmetric) to 1e-3 std (poisson).
    assert abs(values.mean() - same.mean()) < 2e-3 * same.std()
    if isinstance(draw(0.5), int):
        assert set(values) <= set(range(0, 30)) and name in ("integers", "poisson")
    else:
        assert stats.kstest(values, same.cdf).statistic < 1.1e-3  # measured 1e-3 = 1/(2 n)
    assert np.isfinite([draw(0.0), draw(1.0)]).all()


def test_choice_follows_its_weights():
    draw = quantile("choice", {"values": ["a", "b", "c"], "weights": [1, 0, 3]})
    drawn = [draw(u) for u in (np.arange(1000) + 0.5) / 1000]
    assert (drawn.count("a"), drawn.count("b"), drawn.count("c")) == (250, 0, 750)


def test_conditions_and_metrics():
    row = {"docked": True, "force": 3.0, "capture": None, "who": "cpv"}
    for text, holds in (
        ("docked == true", True),
        ("docked != true", False),
        ("force < 3", False),
        ("force <= 3.0", True),
        ('who == "cpv"', True),
        ("who > 1", False),
        ("capture.pitch_error < 1", False),
    ):
        condition = Condition.parse(text)
        assert condition.holds(look_up(row, condition.key, "t")) is holds, text
    assert transformed(-0.5, ["abs", "rad2deg"], "m") == pytest.approx(np.rad2deg(0.5), rel=1e-15)
    assert transformed(True, [], "m") == 1.0 and transformed(float("inf"), [], "m") is None
    with pytest.raises(CampaignError, match=r"metric asks for 'forc'.*docked, force, capture"):
        look_up(row, "forc", "metric")
    with pytest.raises(CampaignError, match=r"metric 'm' is 'cpv'; a metric has to be a number"):
        transformed("cpv", [], "metric 'm'")


def test_runs_go_through_all_cells_and_grow_without_changing():
    small, large = plan(runs=3), plan(runs=5)
    assert [(small.run(i).cell, small.run(i).replicate) for i in range(4)] == [
        (0, 0),
        (1, 0),
        (0, 1),
        (1, 1),
    ]
    assert all(small.run(i) == large.run(i) for i in range(small.total))
    assert len({large.run(i).seed for i in range(large.total)}) == large.total
    assert large.run(0).seed != plan(runs=5, seed=6).run(0).seed


def test_common_seeds_share_seas_and_random_factors_between_cells():
    shared = plan(common_seeds=True)
    first, second, third = (shared.run(i) for i in range(3))
    assert first.seed == second.seed != third.seed
    assert first.factors["north"] == second.factors["north"] != third.factors["north"]
    assert first.factors["depth"] != second.factors["depth"]


def test_one_entry_of_a_vector_changes_and_the_others_stay():
    run = plan().run(1)
    position = plan().scenario(1).vehicles["auv"].position_ned
    assert position == (run.factors["north"], 1.5, 4.0)


def test_cases_change_keys_together():
    text = BASE + (
        "[factors.controller]\ncases = [\n"
        '{ label = "ours", task = { settings = { controller = "cpv", gains = "extended" } } },\n'
        '{ label = "pid", "task.settings.controller" = "pose_pid", '
        '"task.settings.gains" = "manual", "vehicles.auv.actuation" = "wrench" }]\n'
    )
    made = Plan(Campaign.from_toml(text))
    assert [made.cell_factors(c)["controller"] for c in range(2)] == ["ours", "pid"]
    assert made.scenario(0).task.settings["gains"] == "extended"
    assert made.scenario(1).vehicles["auv"].actuation == "wrench"
    made.check()


def test_latin_hypercube_is_stratified_in_every_cell():
    text = CALM.replace('distribution = "normal"', 'distribution = "uniform"').replace(
        "mean = 3.0, std = 0.2 }", 'low = 0.0, high = 8.0 }\nsampling = "latin_hypercube"'
    )
    made = plan(text, runs=8)
    for cell in range(2):
        values = [made.run(8 * 0 + 2 * i + cell).factors["north"] for i in range(8)]
        assert sorted(int(v) for v in values) == list(range(8))
    first = [made.run(2 * i).factors["north"] for i in range(8)]
    second = [made.run(2 * i + 1).factors["north"] for i in range(8)]
    assert first != second
    assert made.hypercube and not plan().hypercube


def test_units_map_to_variations_for_studies_that_choose_their_points():
    values, changes = plan().at([0.5], cell=1)
    assert values == {"depth": 4.0, "north": pytest.approx(3.0, abs=1e-12)}
    assert changes["vehicles.auv.position_ned"][2] == 4.0
