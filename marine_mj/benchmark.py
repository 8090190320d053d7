"""Speed of the physics, as ratios and rates measured in one run on the machine at hand."""

import os
import platform
import subprocess
import sys
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from multiprocessing import get_context

import mujoco
import numpy as np
from mujoco import batch

from marine_mj import scene, simulation
from marine_mj.environment import Environment, irregular_sea
from marine_mj.hydrodynamics import load, start_in_waves
from marine_mj.library import find_model
from marine_mj.scenario import Scenario

#: Rounds of interleaved measurements; the best of each case counts (least disturbed).
ROUNDS = 15
STEPS = 3000
TIMESTEP = 0.005


@dataclass(frozen=True)
class Row:
    """One measurement; `ok` is None where no bar is set."""

    case: str
    metric: str
    value: float
    unit: str
    bar: float | None = None
    ok: bool | None = None


def _at_least(case: str, metric: str, value: float, unit: str, bar: float) -> Row:
    return Row(case, metric, value, unit, bar, bool(value >= bar))


def _at_most(case: str, metric: str, value: float, unit: str, bar: float) -> Row:
    return Row(case, metric, value, unit, bar, bool(value <= bar))


def machine() -> str:
    """Machine, versions and settings of the measurement, one line."""
    name = platform.processor() or platform.machine()
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as lines:
            name = next(line.split(":")[1].strip() for line in lines if "model name" in line)
    except (OSError, StopIteration):
        pass
    return (
        f"{name}, {os.cpu_count()} cores, MuJoCo {mujoco.__version__}, Python "
        f"{platform.python_version()}; implicitfast, {TIMESTEP * 1000:g} ms, best of {ROUNDS}"
    )


def _start(model: mujoco.MjModel, depth: float = 3.0) -> mujoco.MjData:
    """A body in motion below the surface."""
    data = mujoco.MjData(model)
    data.qpos[2] = -depth
    data.qvel[:6] = [0.1, 0.1, 0.1, 0.1, 0.2, 0.1]
    return data


def _seconds(model: mujoco.MjModel, data: mujoco.MjData, steps: int = STEPS) -> float:
    """Wall time of one step, s."""
    mujoco.mj_step(model, data, 20)
    begin = time.perf_counter()
    mujoco.mj_step(model, data, steps)
    return (time.perf_counter() - begin) / steps


def _plain(name: str) -> mujoco.MjModel:
    """A vehicle without water."""
    spec = mujoco.MjSpec.from_file(str(find_model(name)))
    for numeric in list(spec.numerics):
        spec.delete(numeric)
    spec.option.timestep = TIMESTEP
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    model = spec.compile()
    model.opt.gravity[:] = 0  # it would fall out of the numbers' range
    return model


def _best(models: dict[str, mujoco.MjModel], **start: float) -> dict[str, float]:
    """Wall time of one step of each, s: the best of some, in turn."""
    best = dict.fromkeys(models, np.inf)
    for _ in range(ROUNDS):
        for name, model in models.items():
            best[name] = min(best[name], _seconds(model, _start(model, **start)))
    return best


def _single_vehicle() -> list[Row]:
    """One AUV: plain `mj_step` of the same model against calm water and waves."""
    sea = Environment(waves=irregular_sea(1.1, 5.515, components=100, seed=1))
    point = {"hull": {"strips": False}}
    models = {
        "plain": _plain("scout"),
        "auv_calm": load("scout", settings=point),
        "auv_calm_strips": load("scout"),
        "auv_waves_100": load("scout", sea, point),
        "auv_waves_100_strips": load("scout", sea),
    }
    best = _best(models)
    plain = best["plain"]
    ratio = {name: seconds / plain for name, seconds in best.items()}
    unit, metric = "1", "ratio_to_plain_mj_step"
    return [
        Row("auv_plain", "time_per_step", plain * 1e6, "us"),
        _at_most("auv_calm", metric, ratio["auv_calm"], unit, 1.25),
        Row("auv_calm", "steps_per_second", 1 / best["auv_calm"], "1/s"),
        Row("auv_calm_strips", metric, ratio["auv_calm_strips"], unit),
        _at_most("auv_waves_100", metric, ratio["auv_waves_100"], unit, 2.3),
        Row("auv_waves_100_strips", metric, ratio["auv_waves_100_strips"], unit),
    ]


def _floating_vessel() -> list[Row]:
    """One USV with radiation memory: plain `mj_step` of the same model against calm and waves."""
    sea = Environment(waves=irregular_sea(1.1, 5.515, components=100, seed=1))
    models = {
        "plain": _plain("dus_v5750"),
        "usv_constant": load("dus_v5750", settings={"hull": {"radiation": "constant"}}),
        "usv_memory": load("dus_v5750"),
        "usv_memory_waves_100": load("dus_v5750", sea),
    }
    best = _best(models, depth=0.0)
    plain = best.pop("plain")
    ratio = {name: seconds / plain for name, seconds in best.items()}
    unit, metric = "1", "ratio_to_plain_mj_step"
    return [
        Row("usv_plain", "time_per_step", plain * 1e6, "us"),
        Row("usv_constant", metric, ratio["usv_constant"], unit),
        _at_most("usv_memory", metric, ratio["usv_memory"], unit, 2.0),
        Row("usv_memory_waves_100", metric, ratio["usv_memory_waves_100"], unit),
    ]


def _docking_scene() -> list[Row]:
    """AUV with strips, USV, cradle, 100 components: on the approach and pressed into the seat.

    Without what is only seen, as batches run it.
    """
    rows = []
    for motion in ("dynamic", "rao"):
        settings = Scenario.load("docking_demo").with_values({"vehicles.usv.motion": motion})
        model = scene.compile_scene(settings, visual=False).model
        approach, contact = np.inf, np.inf
        contacts = 0
        for _ in range(ROUNDS):
            data = mujoco.MjData(model)
            approach = min(approach, _seconds(model, data))
            data = _seated(model)
            contact = min(contact, _seconds(model, data, 500))
            contacts = data.ncon
        case = f"docking_scene_{motion}"
        rows.append(_at_least(case, "steps_per_second", 1 / approach, "1/s", 30_000))
        rows.append(Row(f"{case}_contact", "contacts", contacts, "1"))
        rows.append(_at_least(f"{case}_contact", "steps_per_second", 1 / contact, "1/s", 30_000))
    return rows


def _seated(model: mujoco.MjModel) -> mujoco.MjData:
    """The AUV in the cradle, moving with it and pressed against the pads by 200 N."""
    data = mujoco.MjData(model)
    start_in_waves(model, data)
    mujoco.mj_forward(model, data)
    auv, usv = model.joint("auv/free"), model.joint("usv/free")
    attitude = data.qpos[usv.qposadr[0] + 3 :][:4]
    data.qpos[auv.qposadr[0] :][:7] = [*data.site("usv/dock/seat").xpos, *attitude]
    data.qvel[auv.dofadr[0] :][:6] = data.qvel[usv.dofadr[0] :][:6]
    data.xfrc_applied[model.body("auv/hull").id, 2] = 200.0
    mujoco.mj_step(model, data, 100)
    return data


def _panels() -> list[Row]:
    """USV on the 496 panels of its hull in sea state 4, 100 components."""
    sea = Environment(waves=irregular_sea(1.1, 5.515, components=100, seed=1))
    model = load("dus_v5750", sea, {"hull": {"hydrostatics": "panels"}})
    best = np.inf
    for _ in range(ROUNDS):
        data = mujoco.MjData(model)
        start_in_waves(model, data)
        best = min(best, _seconds(model, data, 500))
    case = "hull_panels_500_waves_100"
    return [_at_least(case, "steps_per_second", 1 / best, "1/s", 10_000)]


def _batch() -> list[Row]:
    """Gain of the second thread in `mujoco.batch.Batch`."""
    sea = Environment(waves=irregular_sea(1.1, 5.515, components=100, seed=1))
    model = load("scout", sea)
    pools = {threads: batch.Batch(model, 64, nthread=threads) for threads in (1, 2)}
    best = dict.fromkeys(pools, np.inf)
    for pool in pools.values():
        pool.bind("qpos")[:, 2] = -3.0
    # short rounds, many of them: both cores must be undisturbed at the same time
    for _ in range(4 * ROUNDS):
        for threads, pool in pools.items():
            begin = time.perf_counter()
            pool.step(nstep=100)
            best[threads] = min(best[threads], time.perf_counter() - begin)
    return [
        Row("batch_1_thread", "steps_per_second", 64 * 100 / best[1], "1/s"),
        _at_least("batch_2_threads", "ratio_to_1_thread", best[1] / best[2], "1", 1.85),
    ]


#: Runs of the docking campaign per process, and their length, s.
CAMPAIGN_RUNS, CAMPAIGN_DURATION = 300, 15.0


def _campaign_runs(first: int) -> float:
    """Seconds that a process takes for its runs, its kernels loaded before."""
    base = Scenario.load("docking_demo").with_values({"duration": CAMPAIGN_DURATION})
    simulation.run_batch(base.with_values({"duration": 0.1}), n=1)
    begin = time.perf_counter()
    simulation.run_batch(base, [{"seed": first + i} for i in range(CAMPAIGN_RUNS)])
    return time.perf_counter() - begin


def _campaign() -> list[Row]:
    """Docking runs on 2 processes, and one after the other in the dm_control runner.

    Sea state 4, 100 components, 5 ms, 100 Hz control, contacts on; approach and entry. Scaled to
    runs of 100 s.
    """
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        slower = max(pool.map(_campaign_runs, (0, CAMPAIGN_RUNS)))
    per_run = slower / (2 * CAMPAIGN_RUNS) * 100.0 / CAMPAIGN_DURATION
    begin = time.perf_counter()
    log = simulation.run(Scenario.load("docking_demo").with_values({"duration": CAMPAIGN_DURATION}))
    alone = (time.perf_counter() - begin) * 100.0 / log.summary["simulated_time"]
    case, minutes = "docking_campaign", 1000 * per_run / 60
    return [
        Row(case, "runs_of_100_s_per_minute", 60 / per_run, "1/min"),
        Row(case, "ratio_to_single_runner", alone / per_run, "1"),
        Row(case, "ratio_to_10_s_per_run", 10.0 / per_run, "1"),
        _at_most(case, "minutes_for_1000_runs_of_100_s", minutes, "min", 6.0),
    ]


def _first_step() -> list[Row]:
    """Start of the command line to the first step of the demo scenario, as at any later start.

    Kernels and byte code are there, also if the environment forbids to write byte code.
    """
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    command = [sys.executable, "-m", "marine_mj.cli", "run", "docking_demo", "--first-step"]
    best = np.inf
    for _ in range(3):
        begin = time.perf_counter()
        subprocess.run(command, check=True, capture_output=True, env=environment)
        best = min(best, time.perf_counter() - begin)
    return [_at_most("command_line", "start_to_first_step", best, "s", 3.0)]


CASES: dict[str, Callable[[], list[Row]]] = {
    "one vehicle": _single_vehicle,
    "floating vessel": _floating_vessel,
    "docking scene": _docking_scene,
    "hull panels": _panels,
    "batch": _batch,
    "docking campaign": _campaign,
    "command line": _first_step,
}


def run(progress: Callable[[str], None] | None = None) -> list[dict]:
    """Rows {case, metric, value, unit, bar, ok} of all cases, measured now.

    Args:
        progress: called with the name of each case before it runs.
    """
    rows: list[Row] = []
    for name, case in CASES.items():
        if progress is not None:
            progress(name)
        rows += case()
    return [asdict(row) for row in rows]
