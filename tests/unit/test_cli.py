"""Command line: messages and exit codes of what needs no simulation."""

import os
import subprocess
import sys

import numpy as np
import pytest

import marine_mj
from marine_mj import cli
from marine_mj.errors import ModelError
from marine_mj.new_vehicle import new_vehicle


def code_of(capsys, *arguments):
    with pytest.raises(SystemExit) as stop:
        cli.main(list(arguments))
    out = capsys.readouterr()
    return stop.value.code, out.out, out.err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["run", "nonsense"], ", docking_demo, "),
        (["run", "docking_demo", "--set", "sea.sea_stat=3"], "Did you mean 'sea_state'?"),
        (["run", "docking_demo", "--set", "vehicles.auv.model=titanic"], "titanic"),
        (["run", "docking_demo", "--set", "task.settings.gains=best"], "task.settings: gains"),
        (["run", "docking_demo", "--set", "nothing"], "is not KEY=VALUE"),
        (["plot", "none.nc"], "'none.nc' does not exist"),
        (["new-vehicle", "a/b"], "letters, digits and _ only"),
    ],
)
def test_refusals_are_one_message_and_exit_code_1(capsys, arguments, message):
    code, _, err = code_of(capsys, *arguments)
    assert code == 1
    assert err.startswith("error: ") and message in err and "Traceback" not in err


def test_wrong_command_line_is_exit_code_2(capsys):
    assert code_of(capsys, "run")[0] == 2
    assert code_of(capsys, "fly")[0] == 2


def test_list_names_scenarios_and_tasks(capsys):
    code, out, _ = code_of(capsys, "list")
    assert code == 0
    assert "docking_thesis" in out and "docking dock_open" in out


def test_module_runs_as_a_script():
    done = subprocess.run(
        [sys.executable, "-m", "marine_mj.cli", "--help"], capture_output=True, text=True
    )
    assert done.returncode == 0 and "new-vehicle" in done.stdout


def test_new_vehicle_refusals(tmp_path):
    (tmp_path / "there").mkdir()
    with pytest.raises(ModelError, match="exists already"):
        new_vehicle("there", tmp_path)
    with pytest.raises(ModelError, match="mass must be > 0"):
        new_vehicle("x", tmp_path, mass=-1)
    with pytest.raises(ModelError, match="needs 6, 21 or 36 values, got 2"):
        new_vehicle("x", tmp_path, coefficients={"added_mass_frd": [1, 2]})


def test_new_vehicle_is_the_template_with_names_and_numbers(tmp_path):
    folder = new_vehicle(
        "otter",
        tmp_path / "models",
        mass=11.5,
        inertia=[0.16, 0.17, 0.18],
        center_of_gravity=[0.0, 0.01, 0.02],
        buoyancy=114.8,
        coefficients={"added_mass_frd": [5.5, 12.7, 14.57, 0.12, 0.12, 0.12]},
    )
    text = (folder / "otter.xml").read_text()
    assert "VEHICLE" not in text and 'name="hull.displaced_volume"' not in text
    model = marine_mj.load(str(folder))
    body = model.body("hull")
    assert body.mass[0] == 11.5
    np.testing.assert_allclose(body.ipos, [0, -0.01, -0.02])
    np.testing.assert_allclose(sorted(body.inertia), [0.16, 0.17, 0.18])
    np.testing.assert_allclose(
        model.numeric("hull.added_mass_frd").data, [5.5, 12.7, 14.57, 0.12, 0.12, 0.12]
    )
    assert model.numeric("hull.buoyancy").data[0] == 114.8


def test_a_gl_platform_that_does_not_load_stops_no_simulation():
    """Here MUJOCO_GL names a platform whose library is hidden: PyOpenGL finds nothing to load."""
    code = (
        "import sys, types\n"
        "broken = types.ModuleType('OpenGL')\n"
        "broken.__getattr__ = lambda name: (_ for _ in ()).throw(AttributeError(name))\n"
        "sys.modules['OpenGL'] = broken\n"
        "import marine_mj, mujoco\n"
        "from marine_mj import suite\n"
        "print(len(suite.BASE_TASKS), marine_mj.load('scout').nv)\n"
    )
    environment = {**os.environ, "MUJOCO_GL": "egl"}
    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env=environment
    )
    assert result.stdout.split() == ["3", "6"], result.stderr
