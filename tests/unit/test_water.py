"""The water in pictures is the water of the physics."""

import mujoco
import numpy as np
import pytest
from picture_scenes import scene, sea

from marine_mj.environment import WaveField
from marine_mj.errors import RenderError
from marine_mj.textures import Palette, sand, sky_cube
from marine_mj.water import (
    SEABED,
    TOP,
    UNDER,
    WaterSurface,
    add_scenery,
    components,
    elevation,
    palette_from_numbers,
    palette_numbers,
    sheet_axis,
    texel_axis,
)


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    return scene()


@pytest.mark.parametrize("center", [(0.0, 0.0), (137.3, -61.8)])
def test_vertices_lie_on_the_wave_field(model, center):
    field = sea()
    surface = WaterSurface(model, field)
    for time in (0.0, 12.34, 3600.0):
        surface.update(time, center)
        x, y, z = surface.elevation_at_vertices()
        assert abs(x.mean() - center[0]) < 4 and abs(y.mean() - center[1]) < 4
        # Measured 2e-6 m; single precision is enough.
        np.testing.assert_allclose(z, elevation(field, x, y, time), atol=1e-3)
        assert np.abs(z).max() > 0.2


def test_vertices_lie_on_the_wave_field_of_the_physics(model):
    c = components(sea())
    field = WaveField(
        c.omega, c.wavenumber, c.direction, c.amplitude, c.phase, np.inf, 9.81, "constant"
    )
    surface = WaterSurface(model, field)
    surface.update(7.0)
    x, y, z = surface.elevation_at_vertices()
    np.testing.assert_allclose(z, field.elevation(x, y, 7.0), atol=1e-3)


def test_normals_are_those_of_the_surface(model):
    field = sea()
    surface = WaterSurface(model, field)
    surface.update(3.0)
    n = len(surface.axis)
    i = np.flatnonzero(np.abs(surface.axis) < 3)
    x, y = np.meshgrid(surface.axis[i], surface.axis[i], indexing="ij")
    h = 1e-4
    slope_x = (elevation(field, x + h, y, 3.0) - elevation(field, x - h, y, 3.0)) / (2 * h)
    slope_y = (elevation(field, x, y + h, 3.0) - elevation(field, x, y - h, 3.0)) / (2 * h)
    expected = np.stack([-slope_x, -slope_y, np.ones_like(x)], -1)
    expected /= np.linalg.norm(expected, axis=-1, keepdims=True)
    for name, sign in ((TOP, 1), (UNDER, -1)):
        start = model.mesh_normaladr[surface.mesh_id(name)]
        normals = model.mesh_normal[start : start + n * n].reshape(n, n, 3)[np.ix_(i, i)]
        np.testing.assert_allclose(normals, sign * expected, atol=1e-3)


def test_grid_moves_only_when_needed_and_by_whole_cells(model):
    surface = WaterSurface(model, sea())
    surface.update(0.0, (2.0, 1.0))
    assert np.all(surface.center == 0)
    surface.update(0.0, (40.3, 1.0))
    assert abs(surface.center[0] - 40.3) <= surface.spacing / 2
    cells = surface.center / surface.spacing
    np.testing.assert_allclose(cells, np.round(cells), atol=1e-9)
    assert np.abs(model.geom_pos[model.geom(SEABED).id, :2] - surface.center).max() < 10


def test_calm_water_is_flat(model):
    surface = WaterSurface(model, sea(count=0))
    surface.update(5.0)
    assert np.all(surface.elevation_at_vertices()[2] == 0)
    surface.shade(TOP, (0, -5, 2))


def test_short_waves_fade_where_cells_are_coarse(model):
    surface = WaterSurface(model, sea())
    rough = [
        np.std(np.diff(surface.elevation[rows], axis=0)) for rows in (slice(2), slice(100, 102))
    ]
    assert rough[0] < rough[1]


def test_both_sides_have_their_own_colors(model):
    surface = WaterSurface(model, sea())
    for name, camera in ((TOP, (0, -8, 3)), (UNDER, (0, -8, -3))):
        texture = surface.shade(name, camera)
        start = model.tex_adr[texture]
        shape = (model.tex_height[texture], model.tex_width[texture], 3)
        pixels = model.tex_data[start : start + np.prod(shape)].reshape(shape)
        assert pixels.std() > 3
        # Water is bluer than red on either side.
        middle = pixels[80:-80, 80:-80].mean(axis=(0, 1))
        assert middle[2] > middle[0] + 15


def test_scenery_leaves_the_physics_alone():
    xml = '<mujoco><worldbody><body><freejoint/><geom size=".1"/></body></worldbody></mujoco>'
    bare, dressed = mujoco.MjSpec.from_string(xml), mujoco.MjSpec.from_string(xml)
    add_scenery(dressed)
    models = [bare.compile(), dressed.compile()]
    states = []
    for model in models:
        data = mujoco.MjData(model)
        # From 1 m, through the sheet and the visible seabed.
        data.qpos[2] = 1.0
        mujoco.mj_step(model, data, 1000)
        assert data.ncon == 0
        states.append(data.qpos.copy())
    np.testing.assert_array_equal(*states)
    assert models[0].body_mass.sum() == models[1].body_mass.sum()


def test_adding_scenery_twice_is_refused():
    spec = mujoco.MjSpec()
    add_scenery(spec)
    with pytest.raises(RenderError, match="add_scenery was called twice"):
        add_scenery(spec)


def test_a_model_without_scenery_is_refused():
    with pytest.raises(RenderError, match=r"call marine_mj\.water\.add_scenery"):
        WaterSurface(mujoco.MjModel.from_xml_string("<mujoco/>"), sea())


def test_sheet_axis_is_symmetric_and_reaches_the_horizon():
    axis = sheet_axis(0.5, 10.0, 2000.0)
    np.testing.assert_allclose(axis, -axis[::-1])
    assert axis[-1] >= 2000 and np.all(np.diff(axis) > 0.49)
    texels, index = texel_axis(axis, 10.0)
    np.testing.assert_allclose(texels[index], axis, atol=1e-9)


def test_palette_survives_the_model():
    palette = Palette(deep=(0.1, 0.2, 0.3), murk_range=12.0)
    assert palette_from_numbers(palette_numbers(palette)) == palette


def test_textures_have_the_size_that_mujoco_wants():
    assert sky_cube(Palette(), 16).shape == (96, 16, 3)
    assert sand(Palette(), 32).shape == (32, 32, 3)
