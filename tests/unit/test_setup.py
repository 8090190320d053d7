"""The setup script says what is wrong and what to type; nothing is installed here."""

import os
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SCRIPT = ROOT / "scripts" / "setup.sh"


def run(step: str, cwd: Path = ROOT, script: Path = SCRIPT, **env: str):
    """Finished process of one step of the script."""
    return subprocess.run(
        ["sh", str(script), step],
        cwd=cwd,
        env={**os.environ, "MARINE_MJ_APT": "no", **env},
        capture_output=True,
        text=True,
        stdin=subprocess.DEVNULL,
    )


def copy_of(folder: Path) -> Path:
    """The script in an empty project: it works on the folder above its own."""
    target = folder / "scripts" / "setup.sh"
    target.parent.mkdir()
    target.write_text(SCRIPT.read_text())
    return target


def fake_python(folder: Path, body: str) -> Path:
    """An executable that stands for an interpreter."""
    path = folder / "python3.11"
    path.write_text(f"#!/bin/sh\n{body}\n")
    path.chmod(0o755)
    return path


def test_unknown_step_lists_the_allowed_ones():
    done = run("everything")
    assert done.returncode == 1
    assert "unknown step 'everything'; allowed: run, dev, gl" in done.stderr


def test_missing_gl_says_what_to_type_and_goes_on():
    done = run("gl", MARINE_MJ_GL="none")
    assert done.returncode == 0
    assert "there will be no video (MARINE_MJ_GL=none)" in done.stderr
    assert "apt-get install -y libegl1 libegl-mesa0 libgl1-mesa-dri" in done.stderr


def test_wrong_python_version_is_refused(tmp_path):
    script = copy_of(tmp_path)
    python = fake_python(tmp_path, 'case "$1" in --version) echo Python 3.9.2;; *) exit 1;; esac')
    done = run("run", cwd=tmp_path, script=script, PYTHON=str(python))
    assert done.returncode == 1
    assert f"PYTHON={python} is not a Python 3.11 or 3.12. It says: Python 3.9.2" in done.stderr
    assert not (tmp_path / ".venv").exists()


def test_python_without_venv_says_what_to_install(tmp_path):
    script = copy_of(tmp_path)
    python = fake_python(
        tmp_path,
        """case "$2" in
*ensurepip*) exit 1 ;;
*-venv*) echo python3.11-venv ;;
esac""",
    )
    done = run("run", cwd=tmp_path, script=script, PYTHON=str(python))
    assert done.returncode == 1
    assert "has no venv module. As root: apt-get install python3-venv" in done.stderr
    assert "(or python3.11-venv)" in done.stderr
    assert not (tmp_path / ".venv").exists()
