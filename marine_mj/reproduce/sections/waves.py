"""Figure 3.4: how the JONSWAP spectrum is cut into components."""

import numpy as np

from marine_mj.environment import SEA_STATES, docking_jonswap, irregular_sea
from marine_mj.environment.seas import DOCKING_RANGE
from marine_mj.reproduce.sections.base import Job, Outcome, panels

_STATES = (1, 4, 8, 12)


def jonswap_sampling(job: Job) -> Outcome:
    """Spectra of four sea states with their 50 components, and one realisation of each."""
    figure, axes = panels(2, len(_STATES), (13, 6))
    recovered = []
    for (top, bottom), number in zip(axes.T, _STATES, strict=True):
        state = SEA_STATES[number]
        spectrum = docking_jonswap(state.H_s, state.T_p)
        omega = np.linspace(DOCKING_RANGE[0], DOCKING_RANGE[1], 800)
        sea = irregular_sea(
            state.H_s, state.T_p, spectrum="docking_jonswap", components=50, sampling="midpoint",
            seed=number,
        )  # fmt: skip
        width = (DOCKING_RANGE[1] - DOCKING_RANGE[0]) / 50
        density = 0.5 * sea.amplitude**2 / width
        top.bar(sea.omega, density, width, color="C0", alpha=0.4, label="50 components")
        top.plot(omega, spectrum(omega), "C3", lw=1.4, label="JONSWAP")
        top.set(xlabel="ω [rad/s]", xlim=(0, 5), ylim=(0, None))
        top.set_title(f"sea state {number}: $H_s$ {state.H_s:g} m, $T_p$ {state.T_p:.1f} s")
        ratio = sea.significant_height / state.H_s
        recovered.append(f"{ratio:.3f} at sea state {number}")
        time = np.linspace(0, 120, 1201)
        bottom.plot(time, sea.elevation(0.0, 0.0, time), lw=0.8)
        bottom.axvline(2 * np.pi / width, color="k", ls="--", lw=1, label="repeats from here")
        bottom.set(xlabel="time [s]", xlim=(0, 120))
    axes[0, 0].set_ylabel("S(ω) [m² s]")
    axes[1, 0].set_ylabel("elevation [m]")
    axes[0, 0].legend(fontsize="small")
    axes[1, 0].legend(fontsize="small", loc="upper right")
    text = (
        "Equal bins from 0.209 to 6.283 rad/s, each with one component of its mid-point's density. "
        f"Significant height of the components over that of the sea: {', '.join(recovered)}."
    )
    return Outcome([], [job.save(figure, "jonswap_sampling")], text)
