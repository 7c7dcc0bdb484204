"""Plots, pictures, animations and the report page: what they show, not only that they are there."""

from __future__ import annotations

import base64
import re
import subprocess
import warnings
from itertools import pairwise
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pytest
import stand_in
from html_page import Page
from PIL import Image

import lamella as lm
from lamella.body.shape import FACETS
from lamella.errors import DeclarationError, MissingExtraError, ResultFileError
from lamella.result import Cause, Outcome
from lamella.study.findings import Finding
from lamella.study.outputs import write_pictures
from lamella.viz import renderer
from lamella.viz.camera import VIEWS, fit_camera
from lamella.viz.fields import SurfaceSampler
from lamella.viz.page import cell
from lamella.viz.painter import Painter, divided, refined
from lamella.viz.path import plot_path
from lamella.viz.plots import observed_order, plot_comparison, plot_convergence, plot_energy, plot_signals
from lamella.viz.renderer import Body, ColourScale, Sheet
from lamella.viz.report import Figure, Section, Table, write_report
from lamella.viz.scene import _prepare, animation, mode_sheet, picture
from lamella.viz.solids import face_normals, sharp_edges
from lamella.viz.style import RC, save_figure

RENDERERS = [
    "matplotlib",
    pytest.param("pyvista", marks=pytest.mark.skipif(not renderer.opengl_window(), reason="no OpenGL here")),
]


def pixels(path: Path) -> Any:
    return np.asarray(Image.open(path).convert("RGB")).astype(int)


def coloured(image: Any) -> Any:
    """Where a picture is neither white nor grey."""
    return np.ptp(image, axis=-1) > 40


# --- plots


def test_signals_have_a_row_each_with_components_and_units() -> None:
    result = stand_in.result()
    figure = plot_signals(result, ["C.position", "energy.kinetic"])
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["C.position x", "y", "z", "energy.kinetic"]
    assert [axes.get_ylabel() for axes in figure.axes if axes.get_ylabel()] == ["[m]", "[J]"]
    x, y = figure.axes[2].lines[0].get_data()
    np.testing.assert_array_equal(x, result.at)
    np.testing.assert_array_equal(y, result.history("C.position")[:, 2])
    flat = figure.axes[0].get_ylim()
    assert flat[1] - flat[0] > 1e-3  # a component at rest is a straight line, not rounding errors blown up


def test_rotation_matrix_has_three_rows_of_three() -> None:
    figure = plot_signals(stand_in.pendulum(), ["arm.rotation", "pin.torque_local"])
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert titles[:9] == ["arm.rotation xx", "xy", "xz", "arm.rotation yx", "yy", "yz", "arm.rotation zx", "zy", "zz"]
    assert titles[9:] == ["pin.torque_local x", "y", "z"]


def test_rows_of_three_components_and_of_one_fit_below_each_other(tmp_path: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # matplotlib warns where it finds no layout
        save_figure(plot_signals(stand_in.pendulum(), ["arm.rotation", "pin.force", "pin.angle"]), tmp_path / "signals.png")


def test_what_joints_move_is_drawn_unasked() -> None:
    titles = [axes.get_title(loc="left") for axes in plot_signals(stand_in.pendulum()).axes]
    assert {"pin.angle", "pin.force x", "arm.position x", "tip.position x"} <= set(titles)


def test_a_component_can_be_named_and_a_wrong_name_lists_the_right_ones() -> None:
    figure = plot_signals(stand_in.result(), ["C.position.z"])
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["C.position z"]
    with pytest.raises(DeclarationError, match=r"no signal 'C\.speed'.*recorded are C\.position"):
        plot_signals(stand_in.result(), ["C.speed"])


def test_energy_plot_shows_terms_and_balance() -> None:
    result = stand_in.result()
    figure = plot_energy(result)
    upper, lower = figure.axes
    labels = [line.get_label() for line in upper.lines]
    assert labels[:3] == ["Kinetic energy", "Strain energy", "Work of the loads"]
    np.testing.assert_array_equal(upper.lines[1].get_ydata(), result.history("energy.strain"))
    np.testing.assert_array_equal(lower.lines[0].get_ydata(), result.history("energy.balance"))
    assert figure.get_supxlabel() == "Zero: energy turned into heat by damping"
    assert upper.get_ylabel() == "Energy [J]"


def test_path_is_drawn_over_its_load_factor_and_its_load_factor_over_displacements(tmp_path: Path) -> None:
    result = stand_in.snap_through()
    factors = result.history("load_factor").values
    assert np.any(np.diff(factors) < 0)  # beyond a limit point the load falls
    figure = plot_path(result)
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["C x", "y", "z"]
    x, y = figure.axes[2].lines[0].get_data()
    np.testing.assert_array_equal(x, result.history("C.position")[:, 2] - result.history("C.position")[0, 2])
    np.testing.assert_array_equal(y, factors)
    assert figure.axes[2].get_xlabel() == "Displacement [m]"
    assert figure.axes[0].get_ylabel() == "Load factor [–]"
    over = plot_signals(result, ["C.position.z"]).axes[0]
    np.testing.assert_array_equal(over.lines[0].get_xdata(), factors)
    assert over.get_xlabel() == "Load factor [–]"
    sizes = [picture(result, tmp_path / f"{name}.png", at=(0, 5), renderer="matplotlib", width=480) for name in "ab"]
    assert sizes[0].read_bytes() == sizes[1].read_bytes()
    with pytest.raises(DeclarationError, match=r"no load factor or no position; recorded are C\.position"):
        plot_path(stand_in.result())


def test_comparison_draws_the_change_of_each_model_and_marks_early_ends() -> None:
    early = stand_in.result(scale=0.5)
    early.outcome = Outcome(Cause.NOT_CONVERGED, 0.4, 0.5)
    published = (np.array([0.1]), np.array([-0.3]))
    results = {"exact": stand_in.result(), "linear": early}
    figure = plot_comparison(results, "C.position.z", change=True, label="Deflection of C", references={"paper": published})
    axes = figure.axes[0]
    assert [line.get_label() for line in axes.lines] == ["exact", "linear", "paper"]
    deepest = [line.get_ydata().min() for line in axes.lines]
    assert deepest == pytest.approx([-0.8, -0.4, -0.3], abs=1e-12)
    assert axes.get_ylabel() == "Deflection of C [m]"
    assert "stopped at 0.4 of 0.5" in figure.get_supxlabel()
    with pytest.raises(DeclarationError, match=r"several components.*accepted are C\.position\.x"):
        plot_comparison(results, "C.position")


def test_convergence_states_the_observed_order() -> None:
    size = np.array([1.0, 0.5, 0.25])
    assert observed_order(size, 3.0 * size**4) == pytest.approx(4.0, abs=1e-12)
    figure = plot_convergence({"exact": (size, 3.0 * size**4)}, "Element size [m]", orders=(2,))
    assert figure.axes[0].get_legend().get_texts()[0].get_text() == "exact, order 4.00"
    assert [text.get_text() for text in figure.axes[0].get_xticklabels()] == ["0.25", "0.5", "1"]


@pytest.mark.parametrize(
    ("draw", "said"),
    [
        (lambda: plot_signals(stand_in.result(), []), "plot_signals: names = []; accepted is a list of a text, 1 or more"),
        (lambda: plot_signals(stand_in.result(), "tip.position"), "plot_signals: names = 'tip.position'; accepted is a list"),
        (
            lambda: plot_comparison({}, "tip.position.z"),
            "plot_comparison: results = {}; accepted is a mapping of names",
        ),
        (lambda: plot_convergence({}, "h"), "convergence plot: there is no series"),
        (lambda: plot_convergence({"a": ([1, 0.5], [0.1, 0])}, "h"), "errors [0.1, 0.0]; accepted are as many positive sizes"),
        (lambda: plot_convergence({"a": ([1, 0.5], [0.1])}, "h"), "series 'a' has the sizes [1.0, 0.5] and the errors [0.1]"),
    ],
)
def test_figures_of_nothing_are_refused(draw: Any, said: str) -> None:
    with pytest.raises(DeclarationError, match=re.escape(said)):
        draw()


def test_figures_are_saved_alike_and_change_no_global_style(tmp_path: Path) -> None:
    before = dict(matplotlib.rcParams)
    figure = plot_energy(stand_in.result())
    save_figure(figure, tmp_path / "a.png")
    assert coloured(pixels(tmp_path / "a.png")).mean() > 1e-3
    svg = [save_figure(plot_energy(stand_in.result()), tmp_path / f"{name}.svg").read_bytes() for name in "bc"]
    assert svg[0] == svg[1]
    assert {key: matplotlib.rcParams[key] for key in RC} == {key: before[key] for key in RC}
    with pytest.raises(ResultFileError, match=r"unknown suffix '\.bmp'; accepted are \.png, \.svg, \.pdf"):
        save_figure(figure, tmp_path / "a.bmp")
    with pytest.raises(ResultFileError, match="cannot be written"):
        save_figure(figure, tmp_path / "nowhere" / "a.png")


# --- pictures


@pytest.mark.parametrize("name", RENDERERS)
def test_picture_shows_the_deformed_plate_in_colours(tmp_path: Path, name: Any) -> None:
    result = stand_in.result()
    bent = pixels(picture(result, tmp_path / "bent.png", at=0.25, renderer=name, width=960))
    flat = pixels(picture(result, tmp_path / "flat.png", at=0.0, renderer=name, width=960))
    assert bent.shape == flat.shape  # the camera fits all frames, so it does not move
    body = coloured(bent)[:, : int(0.8 * bent.shape[1])]
    assert 0.2 < body.mean() < 0.8
    rows = np.flatnonzero(body.any(axis=1))
    assert (
        rows[-1] > np.flatnonzero(coloured(flat)[:, : int(0.8 * flat.shape[1])].any(axis=1))[-1] + 20
    )  # it hangs lower when bent
    high, low = bent[:, : int(0.8 * bent.shape[1])][body].max(axis=0), bent[:, : int(0.8 * bent.shape[1])][body].min(axis=0)
    assert np.all(high - low > 80)  # from the scale's blue to its yellow


def test_both_renderers_frame_and_colour_alike(tmp_path: Path) -> None:
    if not renderer.opengl_window():
        pytest.skip("no OpenGL here")
    images = [
        pixels(picture(stand_in.result(), tmp_path / f"{name}.png", at=0.25, renderer=name, width=960, field="displacement.z"))
        for name in ("pyvista", "matplotlib")
    ]
    bodies = [coloured(image) for image in images]
    assert (bodies[0] ^ bodies[1]).mean() < 0.02  # silhouettes differ by their edges' smoothing only
    inside = bodies[0] & bodies[1]
    assert np.abs(images[0][inside] - images[1][inside]).mean() < 40  # of 255; their lights differ


def test_several_times_are_panels_of_one_picture(tmp_path: Path) -> None:
    result = stand_in.result(2)
    options: dict[str, Any] = {"renderer": "matplotlib", "width": 960, "field": "von_mises"}
    four = pixels(picture(result, tmp_path / "four.png", at=(0.0, 0.1, 0.2, 0.25), **options))
    middle = four.shape[1] * 490 // 600 // 2
    left, right = coloured(four[:, :middle]), coloured(four[:, middle : 2 * middle])
    assert left.mean() > 0.1
    assert right.mean() > 0.1
    assert four.shape[0] > 1.5 * pixels(picture(result, tmp_path / "one.png", at=0.0, **{**options, "width": 480})).shape[0]


def test_scale_enlarges_the_displacement_and_says_so(tmp_path: Path) -> None:
    result = stand_in.result()
    true = pixels(picture(result, tmp_path / "true.png", view="front", at=0.25, renderer="matplotlib", width=960))
    large = pixels(picture(result, tmp_path / "large.png", view="front", at=0.25, scale=2.0, renderer="matplotlib", width=960))
    assert large.shape[0] > 1.4 * true.shape[0]


@pytest.mark.parametrize("name", RENDERERS)
def test_animation_moves(tmp_path: Path, name: Any) -> None:
    path = animation(stand_in.result(), tmp_path / "swing.gif", renderer=name, width=300, frames=5, seconds=1.0)
    film = Image.open(path)
    shots = []
    for number in range(film.n_frames):  # type: ignore[attr-defined]
        film.seek(number)
        shots.append(np.asarray(film.convert("RGB")).astype(int))
    assert len(shots) == 5
    assert film.info["duration"] == 200
    assert film.info["loop"] == 0
    moved = [np.abs(a - b).mean() for a, b in pairwise(shots)]
    assert min(moved) > 1.0  # grey levels; a still picture gives zero


def test_wrong_requests_name_what_is_accepted(tmp_path: Path) -> None:
    result = stand_in.result()
    cases: list[tuple[dict[str, Any], str]] = [
        ({"field": "stress"}, "no field 'stress'; accepted are displacement"),
        ({"field": "displacement.w"}, "no component 'w'; accepted are displacement.x"),
        ({"field": "curvature"}, "no magnitude; accepted are curvature.xx"),
        ({"view": "behind"}, "no view 'behind'; accepted are isometric"),
        ({"view": (0.0, 0.0, 0.0)}, "has no length"),
        ({"at": []}, "picture: at = []; accepted is a finite number, or a list of one or more, or None"),
        ({"at": float("nan")}, "at = nan; accepted is a finite number"),
        ({"scale": float("nan")}, "scale = nan; accepted is a finite number"),
        ({"per_element": 0}, "per_element = 0; accepted is a whole number, 1 or more"),
        ({"width": 5}, "width = 5; accepted is a whole number, 300 or more"),
        ({"renderer": "blender"}, "renderer = 'blender'; accepted are auto, pyvista, matplotlib"),
    ]
    for options, message in cases:
        with pytest.raises(DeclarationError, match=re.escape(message)):
            picture(result, tmp_path / "x.png", **options)
    with pytest.raises(ResultFileError, match=r"unknown suffix '\.avi'; accepted are \.gif and \.mp4"):
        animation(result, tmp_path / "x.avi")
    with pytest.raises(DeclarationError, match="animation: frames = 0; accepted is a whole number, 1 or more"):
        animation(result, tmp_path / "x.gif", frames=0)
    with pytest.raises(DeclarationError, match="animation: seconds = nan; accepted is a positive number, or None"):
        animation(result, tmp_path / "x.gif", seconds=float("nan"))
    with pytest.raises(DeclarationError, match=r"mode_sheet: modes = .*; accepted is natural modes or buckling shapes"):
        mode_sheet(result, tmp_path / "x.png")  # type: ignore[arg-type]
    empty = stand_in.result()
    empty.frame_at = np.empty(0)
    with pytest.raises(DeclarationError, match="no frame"):
        picture(empty, tmp_path / "x.png")


# --- rigid bodies


def grey(image: Any) -> Any:
    """Where a picture shows the neutral colour of rigid bodies or their edges: grey, and not white."""
    return (np.ptp(image, axis=-1) < 40) & (image.max(axis=-1) < 230)


@pytest.mark.parametrize("name", RENDERERS)
def test_rigid_bodies_are_drawn_in_grey_without_a_colour_bar(tmp_path: Path, name: Any) -> None:
    result = stand_in.pendulum()
    options: dict[str, Any] = {"renderer": name, "width": 800, "view": "front"}
    start, end = (pixels(picture(result, tmp_path / f"{at}.png", at=at, **options)) for at in (0.0, 0.2))
    assert not coloured(end).any()
    assert start.shape == end.shape
    columns = np.flatnonzero(grey(start)[60:].any(axis=0))  # below the caption
    assert columns[0] < 0.05 * start.shape[1]
    assert columns[-1] > 0.95 * start.shape[1]  # no room is kept for a bar
    lowest = [np.flatnonzero(grey(image).any(axis=1))[-1] for image in (start, end)]
    assert lowest[1] > lowest[0] + 20  # it has swung down
    area = grey(start)[60:].sum() / start.shape[1] ** 2
    span = 1.06 * 1.3  # width of the scene at the start [m], which is the widest
    assert area == pytest.approx((0.2 + np.pi * 0.15**2) / span**2, rel=0.04)  # box and ball side by side, nothing else


def test_both_renderers_show_bodies_alike(tmp_path: Path) -> None:
    if not renderer.opengl_window():
        pytest.skip("no OpenGL here")
    names = ("pyvista", "matplotlib")
    images = [pixels(picture(stand_in.pendulum(), tmp_path / f"{name}.png", renderer=name, width=800)) for name in names]
    assert (grey(images[0]) ^ grey(images[1])).mean() < 0.02
    both = grey(images[0]) & grey(images[1])
    assert np.abs(images[0][both] - images[1][both]).mean() < 40  # of 255; their lights differ


def test_bodies_without_shape_draw_nothing(tmp_path: Path) -> None:
    system = lm.System()
    system.add(lm.RigidBody("hub", mass=1.0, inertia=(1.0, 1.0, 1.0), markers={"tip": (1.0, 0.0, 0.0)}))
    result = lm.simulate(system, 0.01, lm.GeneralizedAlpha(dt=5e-3))
    for draw in (picture, animation):
        with pytest.raises(DeclarationError, match="the model has nothing to draw; accepted is one with a plate, or a body with"):
            draw(result, tmp_path / "x.gif", renderer="matplotlib")
    assert {path.name for path in write_pictures(result, tmp_path / "pictures")} == {"signals.png", "energy.png"}


def test_animation_of_rigid_bodies_moves(tmp_path: Path) -> None:
    film = Image.open(animation(stand_in.pendulum(), tmp_path / "swing.gif", renderer="matplotlib", width=300, frames=3))
    shots = []
    for number in range(3):
        film.seek(number)
        shots.append(np.asarray(film.convert("RGB")).astype(int))
    assert all(np.abs(a - b).mean() > 1.0 for a, b in pairwise(shots))


def test_painter_sorts_bodies_and_plates_by_depth() -> None:
    x, y = np.meshgrid([-1.0, 1.0], [-1.0, 1.0])
    vertices, faces = lm.Box((1.0, 1.0, 1.0)).surface()
    box = Body(vertices, faces, sharp_edges(vertices, faces))
    camera = fit_camera(np.array([[-1.0, -1.0, 0.0], [1.0, 1.0, 0.0]]), "top")
    painter = Painter(camera, ColourScale("viridis", 0.0, 1.0), (60, 60))
    for z, in_front in ((0.8, True), (-0.8, False)):
        sheet = Sheet(np.stack([x, y, z + 0 * x], -1), np.ones((2, 2)), [], [])
        image = painter.draw([sheet], [box]).astype(int)
        assert coloured(image)[25, 25] == in_front  # beside the middle, where no edge runs
        assert coloured(image)[5, 5]


@pytest.mark.parametrize(
    ("shape", "edges"), [(lm.Box((1.0, 2.0, 3.0)), 12), (lm.Cylinder(1.0, 0.5), 2 * FACETS), (lm.Sphere(2.0), 0)]
)
def test_sharp_edges_of_solids(shape: Any, edges: int) -> None:
    points, faces = shape.surface()
    found = sharp_edges(points, faces)
    assert len(found) == edges
    if edges == 2 * FACETS:  # the rims, not the facets
        np.testing.assert_allclose(np.abs(points[found][..., 2]), 0.25)
    assert np.all(np.sum(face_normals(points[faces]) * points[faces].mean(axis=1), axis=1) > 0)  # outward


def test_divided_face_keeps_its_corners_and_area() -> None:
    quad = np.array([[0.0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]])
    cells = divided(quad, 0.3)
    assert cells.shape == (7 * 4, 4, 3)
    area = 0.5 * np.linalg.norm(np.cross(cells[:, 2] - cells[:, 0], cells[:, 3] - cells[:, 1]), axis=1)
    np.testing.assert_allclose(area.sum(), 2.0)
    np.testing.assert_array_equal([cells[0, 0], cells[-1, 2]], [quad[0], quad[2]])


def test_plates_of_one_picture_share_a_colour_scale() -> None:
    result = stand_in.result(4)
    frame = 5
    lengths = [np.linalg.norm(shot.displacement, axis=-1).max() for shot in SurfaceSampler(result, 2).at(frame)]
    assert max(lengths) > 1.5 * min(lengths)  # the stand-ins bend the more the farther they are
    drawing = _prepare(result, "displacement", 1.0, 4, "isometric", [frame])
    assert (drawing.colours.low, drawing.colours.high) == (0.0, pytest.approx(max(lengths)))


# --- choosing a renderer


@pytest.fixture
def fresh_probe() -> Any:
    """The probe is asked anew, before and after."""
    renderer.opengl_window.cache_clear()
    yield
    renderer.opengl_window.cache_clear()


def made(name: Any) -> str:
    camera = fit_camera(np.eye(3), "isometric")
    return type(renderer.make_renderer(name, camera, ColourScale("viridis", 0.0, 1.0), (40, 30))).__name__


@pytest.mark.usefixtures("fresh_probe")
@pytest.mark.parametrize("failure", ["crash", "blank", "hang", "missing"])
def test_matplotlib_takes_over_where_opengl_fails(monkeypatch: pytest.MonkeyPatch, failure: str) -> None:
    def run(command: list[str], **options: Any) -> subprocess.CompletedProcess[str]:
        if failure == "hang":
            raise subprocess.TimeoutExpired(command, options["timeout"])
        return subprocess.CompletedProcess(command, -11 if failure == "crash" else 0, "blank vtkEGLRenderWindow\n", "")

    monkeypatch.delenv(renderer.CHOICE, raising=False)
    if failure == "missing":
        monkeypatch.setattr(renderer.importlib.util, "find_spec", lambda name: None)
    else:
        monkeypatch.setattr(renderer.subprocess, "run", run)
    assert made("auto") == "Painter"
    with pytest.raises(
        MissingExtraError, match=r"pip install 'lamella\[viz\]'" if failure == "missing" else "needs an OpenGL library"
    ):
        made("pyvista")


@pytest.mark.usefixtures("fresh_probe")
def test_the_environment_may_choose(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(renderer.CHOICE, "matplotlib")
    monkeypatch.setattr(renderer.subprocess, "run", lambda *_, **__: pytest.fail("no probe is needed"))
    assert made("auto") == "Painter"


# --- camera and painter


@pytest.mark.parametrize("view", [*VIEWS, (1.0, 2.0, -0.5)])
def test_camera_sees_everything_and_z_is_up(view: Any) -> None:
    points = np.random.default_rng(1).normal(size=(50, 3)) * [3.0, 1.0, 0.2]
    camera = fit_camera(points, view)
    flat, _ = camera.project(points)
    assert np.abs(flat).max() < 1.0
    assert np.abs(flat).max() > 0.9  # and large
    assert camera.up @ ([0.0, 1.0, 0.0] if view == "top" else [0.0, 0.0, 1.0]) > 0
    np.testing.assert_allclose(np.cross(camera.right, camera.up), -camera.look, atol=1e-14)


def test_painter_hides_what_is_behind() -> None:
    x, y = np.meshgrid([0.0, 1.0], [0.0, 1.0])
    lower, upper = (Sheet(np.stack([x, y, z + 0 * x], -1), np.full((2, 2), v), [], []) for z, v in ((0, 0.0), (1, 1.0)))
    camera = fit_camera(upper.points.reshape(-1, 3), "top")
    painter = Painter(camera, ColourScale("viridis", 0.0, 1.0), (40, 40))
    for order in ([lower, upper], [upper, lower]):
        middle = painter.draw(order)[20, 20]
        assert middle[0] > 150  # the upper sheet's yellow,
        assert middle[2] < 120  # not the lower one's blue


def test_refined_grid_keeps_its_points_and_is_linear_between() -> None:
    grid = np.random.default_rng(2).normal(size=(3, 4, 2))
    fine = refined(grid, (2, 3))
    assert fine.shape == (5, 10, 2)
    np.testing.assert_allclose(fine[::2, ::3], grid, atol=1e-15)
    np.testing.assert_allclose(fine[0, 1], (2 * grid[0, 0] + grid[0, 1]) / 3)
    np.testing.assert_allclose(fine[1, 0], (grid[0, 0] + grid[1, 0]) / 2)


def test_painter_sorts_long_cells_by_depth() -> None:
    """A ramp of long cells rises through a slab and hides it where it is above it."""
    x, y = np.meshgrid(np.linspace(-1.0, 1.0, 65), [-1.0, 1.0])
    slab = Sheet(np.stack([x, y, 0 * x], -1), np.zeros(x.shape), [], [])
    ramp = Sheet(np.stack([0.5 * x, y, 0.5 * y], -1), np.ones(x.shape), [], [])
    camera = fit_camera(slab.points.reshape(-1, 3), "top")
    image = Painter(camera, ColourScale("viridis", 0.0, 1.0), (80, 80)).draw([slab, ramp]).astype(int)
    redder = image[[15, 37, 43, 65], 40, 0] > image[[15, 37, 43, 65], 40, 2]  # the ramp's yellow, not the slab's blue
    assert redder.tolist() == [True, True, False, False]


# --- report


def test_report_is_one_whole_page(tmp_path: Path) -> None:
    result = stand_in.result()
    result.outcome = Outcome(Cause.INTERRUPTED, 0.4, 0.5)
    shot = save_figure(plot_energy(result), tmp_path / "energy.png")
    section = Section(
        "Energy <balance>",
        "First part.\n\nSecond part.",
        [Figure(shot, "From a file."), Figure(plot_signals(result), "From memory.")],
        [Table(["mesh", "error", "passed"], [["4 × 4", -1.23456789e-3, True], ["8 × 8", 12345, False]])],
    )
    found = Finding("Stiffens & swings.", True, {"ratio": 0.6, "note": "large"}, "As the paper says.")
    path = write_report(
        tmp_path / "report.html",
        "A <plate>",
        [section],
        [found],
        summary="Short.",
        model_text="plate: {a: 1}",
        results={"exact": result},
    )
    page = Page(path.read_text(encoding="utf-8"))
    assert all(link and link.startswith(("data:", "#")) for link in page.links)  # nothing is loaded from elsewhere
    assert "@import" not in path.read_text()
    assert [image["alt"] for image in page.images] == ["From a file.", "From memory."]
    first = page.images[0]["src"] or ""
    assert base64.b64decode(first.partition("base64,")[2]) == shot.read_bytes()
    assert (page.images[1]["src"] or "").startswith("data:image/svg+xml;base64,")
    for text in (
        "A <plate>",
        "Energy <balance>",
        "Stiffens & swings.",
        "As the paper says.",
        "−0.00123457",
        "12 345",
        "plate: {a: 1}",
    ):
        assert text in page.text
    assert "stopped at 0.4 of 0.5: interrupted by the user" in page.text
    assert f"numpy {np.__version__}" in page.text


def test_report_says_which_picture_is_missing(tmp_path: Path) -> None:
    for name, message in (("none.png", r"none\.png' cannot be read"), ("model.step", "unknown kind; accepted are .png")):
        with pytest.raises(ResultFileError, match=message):
            write_report(tmp_path / "r.html", "t", [Section("s", figures=[Figure(tmp_path / name)])])
    with pytest.raises(ResultFileError, match="cannot be written"):
        write_report(tmp_path / "nowhere" / "r.html", "t")


@pytest.mark.parametrize(
    ("value", "text"),
    [(True, "yes"), (1234567, "1 234 567"), (-0.5, "−0.5"), (np.float64(2e-9), "2e−09"), ("a-b", "a-b"), (None, "None")],
)
def test_cells(value: Any, text: str) -> None:
    assert cell(value).replace(" ", " ").replace(" ", " ") == text
