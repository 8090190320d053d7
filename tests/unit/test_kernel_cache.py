"""The process that simulates never compiles the kernels itself."""

import subprocess
import sys

from marine_mj.hydrodynamics import kernel_cache

CODE = """
import marine_mj
from marine_mj.hydrodynamics.kernels import callbacks
print(all(f.cache_hits for f in (callbacks.passive, callbacks.report, callbacks.act_dyn)))
"""


def test_kernels_come_from_the_cache():
    done = subprocess.run([sys.executable, "-c", CODE], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "True"
    assert kernel_cache._stamp().exists()


def test_a_missing_stamp_starts_one_process_that_compiles(monkeypatch, tmp_path):
    started = []
    monkeypatch.delenv(kernel_cache.VARIABLE, raising=False)
    monkeypatch.setattr(kernel_cache, "_stamp", lambda: tmp_path / "new" / "kernels-0.stamp")
    monkeypatch.setattr(
        kernel_cache.subprocess, "run", lambda command, **options: started.append(options["env"])
    )
    kernel_cache.compile_kernels()
    kernel_cache.compile_kernels()
    assert [env[kernel_cache.VARIABLE] for env in started] == ["1"]
    monkeypatch.setenv(kernel_cache.VARIABLE, "1")
    (tmp_path / "new" / "kernels-0.stamp").unlink()
    kernel_cache.compile_kernels()
    assert len(started) == 1


def test_where_no_process_can_be_started_this_one_compiles(monkeypatch, tmp_path):
    def refuse(*_, **__):
        raise OSError("no processes here")

    monkeypatch.setattr(kernel_cache, "_stamp", lambda: tmp_path / "kernels-0.stamp")
    monkeypatch.setattr(kernel_cache.subprocess, "run", refuse)
    kernel_cache.compile_kernels()
    assert not (tmp_path / "kernels-0.stamp").exists()
