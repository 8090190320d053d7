"""The command `marine-mj hydro`: hydrodynamics of a hull mesh."""

from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table

_Text = str | None
_Number = float | None


def hydro_command(
    mesh: Annotated[str, typer.Argument(help="Mesh file, or vehicle with a hull_mesh.")],
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="NetCDF file; pictures go beside it.")
    ] = None,
    scale: Annotated[float, typer.Option(help="Metres per unit of the mesh (0.001: mm).")] = 1.0,
    waterline: Annotated[
        _Number, typer.Option(help="Height z of the still water in the mesh, m; default 0.")
    ] = None,
    draught: Annotated[_Number, typer.Option(help="Instead: depth of the lowest point, m.")] = None,
    mass: Annotated[_Number, typer.Option(help="kg; default: displaced mass.")] = None,
    center_of_gravity: Annotated[
        _Text, typer.Option(help="'x y z' in the mesh (x forward, y port, z up), m.")
    ] = None,
    inertia: Annotated[_Text, typer.Option(help="'Ix Iy Iz' about that point, kg m2.")] = None,
    gyration: Annotated[_Text, typer.Option(help="Instead: radii 'rx ry rz', m.")] = None,
    density: Annotated[float, typer.Option(help="Of the water, kg/m3.")] = 1025.0,
    gravity: Annotated[float, typer.Option(help="m/s2.")] = 9.81,
    depth: Annotated[float, typer.Option(help="Of the water, m.")] = float("inf"),
    omega: Annotated[
        _Text, typer.Option(help="Frequencies, rad/s; default: 40 by the hull's length.")
    ] = None,
    periods: Annotated[_Text, typer.Option(help="Instead: periods, s.")] = None,
    directions: Annotated[
        _Text,
        typer.Option(help="Directions of travel, deg (0 following); default: every 15 or less."),
    ] = None,
    panel: Annotated[
        _Number, typer.Option(help="Panel size, m; default: about 700 panels.")
    ] = None,
    symmetry: Annotated[bool, typer.Option(help="Use mirror planes of the mesh.")] = True,
    lid: Annotated[bool, typer.Option(help="Lid against irregular frequencies.")] = True,
    submerged: Annotated[
        bool | None,
        typer.Option(
            "--submerged/--waves",
            help="Unbounded fluid, or waves; default: waves where the hull reaches the surface.",
        ),
    ] = None,
    method: Annotated[
        str, typer.Option(help="Boundary integral equation: direct or indirect.")
    ] = "direct",
    drift: Annotated[
        bool, typer.Option("--drift", help="Add the mean wave drift (indirect method).")
    ] = False,
    shelter: Annotated[
        bool,
        typer.Option(
            "--shelter", help="Write NAME_shelter.nc: water around the hull (indirect method)."
        ),
    ] = False,
    memory: Annotated[
        bool, typer.Option(help="Fit the radiation memory and store it in the database.")
    ] = True,
    memory_band: Annotated[
        _Text, typer.Option(help="Frequencies 'low high' that the memory is fitted to, rad/s.")
    ] = None,
    repair: Annotated[
        bool, typer.Option("--repair", help="Turn inward faces, drop doubled ones and flat ones.")
    ] = False,
    roll_damping: Annotated[
        float, typer.Option(help="Viscous roll damping, share of critical (0.07).")
    ] = 0.0,
    pitch_damping: Annotated[
        float, typer.Option(help="Viscous pitch damping, share of critical.")
    ] = 0.0,
    viscous: Annotated[
        _Text, typer.Option(help="Viscous damping, 6 or 36 values, N s/m ... N m s.")
    ] = None,
    quadratic: Annotated[
        _Text, typer.Option(help="Quadratic damping, 6 values, linearised in the RAOs.")
    ] = None,
    amplitude: Annotated[float, typer.Option(help="Of the waves for --quadratic, m.")] = 1.0,
    convergence: Annotated[
        bool, typer.Option("--convergence", help="Repeat with coarser panels and extrapolate.")
    ] = False,
    hydrostatics: Annotated[
        bool, typer.Option("--hydrostatics", help="Stop after mesh checks and hydrostatics.")
    ] = False,
) -> None:
    """Added mass, wave forces and RAOs of a hull from its mesh.

    Writes NAME.nc (a wave database) with NAME_raos.png, NAME_forces.png and NAME_radiation.png,
    with --shelter also NAME_shelter.nc (a shelter database, for vehicles below the hull); needs the
    extra `bem`. Lists of numbers are quoted: --periods "2 3 4".
    """
    import numpy as np

    from marine_mj.cli import _numbers, _progress, console, errors
    from marine_mj.errors import ModelError
    from marine_mj.hydrodynamics.bem.settings import Settings
    from marine_mj.hydrodynamics.bem.study import read_hull

    if omega is not None and periods is not None:
        raise ModelError("both --omega and --periods are given, allowed is one of them")

    def numbers(option: str, text: str | None) -> tuple[float, ...] | None:
        return None if text is None else tuple(_numbers(option, text))

    band = numbers("--memory-band", memory_band)
    if band is not None and not (len(band) == 2 and 0 <= band[0] < band[1]):
        raise ModelError(
            f"--memory-band is {memory_band!r}; allowed are a lower and a higher frequency, rad/s"
        )
    frequencies = numbers("--omega", omega)
    listed = numbers("--periods", periods)
    if listed is not None:
        frequencies = tuple(2 * np.pi / t if t > 0 else -1.0 for t in listed)
    degrees = numbers("--directions", directions)
    hull = read_hull(
        mesh,
        Settings(
            scale=scale,
            waterline=waterline,
            draught=draught,
            mass=mass,
            center_of_mass=numbers("--center-of-gravity", center_of_gravity),
            inertia=numbers("--inertia", inertia),
            gyration=numbers("--gyration", gyration),
            density=density,
            gravity=gravity,
            depth=depth,
            omega=frequencies,
            directions=None if degrees is None else tuple(np.radians(degrees).tolist()),
            panel=panel,
            symmetry=symmetry,
            lid=lid,
            submerged=submerged,
            method=method,
            drift=drift,
            shelter=shelter,
            repair=repair,
            roll_damping=roll_damping,
            pitch_damping=pitch_damping,
            viscous=numbers("--viscous", viscous),
            quadratic=numbers("--quadratic", quadratic),
            amplitude=amplitude,
        ),
    )
    _show_hull(hull, console)
    for note in hull.notes:
        errors.print(f"note: {note}", markup=False, highlight=False, soft_wrap=True)
    if hydrostatics:
        return

    from marine_mj.hydrodynamics.bem import figures
    from marine_mj.hydrodynamics.bem.database import save_database
    from marine_mj.hydrodynamics.bem.response import database_of, respond, shelter_of

    path = output or Path("results") / "hydro" / f"{hull.name}.nc"
    with _progress() as report:
        response = respond(hull, progress=lambda done, total: report("frequencies", done, total))
        data = database_of(hull, response)
        field = shelter_of(hull, response) if shelter else None
        rows = None
        if convergence:
            from marine_mj.hydrodynamics.bem.convergence import convergence as study

            rows = study(hull, progress=lambda done, total: report("convergence", done, total))
    for note in str(data.attrs["assumptions"]).split("; "):
        if note and note not in hull.notes:
            errors.print(f"note: {note}", markup=False, highlight=False, soft_wrap=True)
    made = {}
    if "RAO" in data:
        made = {
            "raos": figures.plot_raos(data),
            "forces": figures.plot_raos(data, "excitation_force"),
            "radiation": figures.plot_radiation(data),
        }
    if rows is not None:
        ratios = {r.name: r.values / r.limit for r in rows if abs(r.limit) > 0}
        title = f"Convergence with the panels: {hull.name}"
        made["convergence"] = figures.plot_convergence(rows[0].sizes, ratios, title)
    _show_results(data, rows, console)
    written = [save_database(data, path)]
    if field is not None:
        console.print(
            f"shelter: {field.sizes['mode']} modes, left out {field.attrs['left_out']}",
            highlight=False,
            soft_wrap=True,
        )
        written.append(save_database(field, path.with_name(f"{path.stem}_shelter.nc")))
    for name, figure in made.items():
        written.append(path.with_name(f"{path.stem}_{name}.png"))
        figure.savefig(written[-1])
    for file in written:
        console.print(f"wrote {file}", markup=False, highlight=False, soft_wrap=True)
    if memory and "RAO" in data:
        _fit_memory(path, console, band)


def _fit_memory(path: Path, console: Any, band: Any) -> None:
    """Fit the radiation memory, store it in the database and show how well it fits."""
    from marine_mj.hydrodynamics.fit_database import store_memory
    from marine_mj.hydrodynamics.memory_store import memory_report

    store_memory(path, band=band)
    table = Table("radiation memory", "order", "R2 of B", "R2 of A", "error", box=None)
    for fit in memory_report(str(path)):
        cells = (f"{fit.r2_damping:.5f}", f"{fit.r2_added_mass:.5f}", f"{100 * fit.error:.2g} %")
        table.add_row(fit.name, str(fit.order), *cells)
    console.print(table)


def _show_hull(hull: Any, console: Any) -> None:
    """Table of the hydrostatics, lengths in the waterline frame."""
    still, body = hull.still, hull.body
    table = Table("hydrostatics", "", "unit", box=None, pad_edge=False)
    place = "{:.4g} {:.4g} {:.4g}".format

    def add(name: str, value: Any, unit: str) -> None:
        table.add_row(name, value if isinstance(value, str) else f"{value:.5g}", unit)

    add("mesh", f"{hull.source}, {len(hull.mesh.triangles)} faces", "")
    add("length, breadth under water", f"{still.length:.4g} {still.breadth:.4g}", "m")
    add("draught", still.draught, "m")
    add("displaced volume", still.volume, "m3")
    add("wetted surface", still.wetted_surface, "m2")
    add("mass", body.mass, "kg")
    add("centre of buoyancy (z = 0: water)", place(*(still.center_of_buoyancy + 0.0)), "m")
    add("centre of gravity", place(*(body.center_of_mass + 0.0)), "m")
    heights = still.metacentric_heights(body.center_of_mass)
    if still.waterplane_area > 0:
        add("waterplane area", still.waterplane_area, "m2")
        add("centre of flotation", "{:.4g} {:.4g}".format(*(still.waterplane_center + 0.0)), "m")
        add("GM_T", heights[0], "m")
        add("GM_L", heights[1], "m")
    else:
        add("buoyancy above gravity", heights[0], "m")
    C = hull.stiffness
    add("stiffness 33 44 55", " ".join(f"{C[i, i]:.5g}" for i in (2, 3, 4)), "N/m, N m")
    console.print(table)


def _show_results(data: Any, rows: Any, console: Any) -> None:
    """Tables of added mass, natural periods and convergence."""
    import json

    from marine_mj.hydrodynamics.raos import DOFS

    table = Table("", *(d.lower() for d in DOFS), box=None, pad_edge=False)
    listed = (("M_RB", "inertia_matrix"), ("A(0)", "zero_frequency_added_mass"))
    for label, name in (*listed, ("A(inf)", "infinite_added_mass")):
        if name in data:
            table.add_row(label, *(f"{data[name].values[i, i]:.5g}" for i in range(6)))
    periods = json.loads(data.attrs.get("natural_periods", "{}"))
    if periods:
        cells = [f"{periods[d]:.3g} s" if d in periods else "" for d in DOFS]
        table.add_row("natural period", *cells)
    console.print(table)
    console.print(
        f"{data.attrs['mesh']}; volume of the panels {100 * data.attrs['panel_volume_error']:+.2g} "
        f"%, asymmetry {100 * data.attrs['asymmetry_before_symmetrising']:.2g} %",
        highlight=False,
        soft_wrap=True,
    )
    if rows is None:
        return
    heads = [f"{h:.3g} m" for h in rows[0].sizes]
    table = Table("convergence", *heads, "order", "limit", "uncertainty", box=None, pad_edge=False)
    for r in rows:
        off = 100 * r.uncertainty / abs(r.limit) if r.limit else float("nan")
        order = f"{r.order:.2g}" if r.order == r.order else "-"
        cells = [f"{v:.5g}" for v in r.values]
        table.add_row(r.name, *cells, order, f"{r.limit:.5g}", f"{off:.2g} %")
    console.print(table)
