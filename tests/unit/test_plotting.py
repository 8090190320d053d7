"""Figures of logs: complete, labelled with units, for whatever a log holds."""

import pytest
import xarray as xr
from picture_scenes import dataset

from marine_mj.errors import LogError
from marine_mj.plotting import events, plot_run


def titles(figure) -> list[str]:
    return [axis.get_title(loc="left") for axis in figure.axes if axis.get_visible()]


def test_docking_run_shows_every_panel(tmp_path):
    figure = plot_run(dataset())
    shown = " / ".join(titles(figure))
    for name in ("Track", "Depth", "Way to the dock", "pitch", "Speed", "relative", "Contact"):
        assert name in shown
    assert "Forces on usv" in shown and "Forces on auv" in shown
    figure.savefig(tmp_path / "run.png")
    assert (tmp_path / "run.png").stat().st_size > 20_000


def test_every_axis_has_a_unit():
    figure = plot_run(dataset())
    for axis in figure.axes:
        if axis.get_visible() and axis.get_title(loc="left"):
            assert "(" in axis.get_xlabel() and "(" in axis.get_ylabel()


def test_events_are_phases_contact_and_latch_in_order():
    labels = [event.label for event in events(dataset())]
    assert labels == ["under", "wait", "enter", "first contact", "latched"]


def test_no_phase_is_no_event():
    data = dataset()
    data["phase"][:] = float("nan")
    assert [event.label for event in events(data)] == ["first contact", "latched"]


def test_log_without_dock_or_names():
    data = dataset(docking=False).drop_vars("vehicle")
    figure = plot_run(data)
    assert "Contact force" not in titles(figure)
    legend = figure.axes[1].get_legend()
    assert [text.get_text() for text in legend.get_texts()] == ["vehicle 0", "vehicle 1"]


def test_a_dataset_that_is_no_log_is_refused():
    with pytest.raises(LogError, match="no time and no eta_ned"):
        plot_run(xr.Dataset())
