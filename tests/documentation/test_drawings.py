"""The drawings of the documentation have the geometry, the signs and the numbers of the package."""

import re
from pathlib import Path

import drawings
import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.text import Annotation

import contactlab as cl

ROOT = Path(__file__).resolve().parents[2]


def extents(drawing: str) -> np.ndarray:
    """Return the extents of all paths of an SVG but those of its letters, shape (path, 4) [pt]."""
    shown = re.sub(r"<defs>.*?</defs>", "", drawing, flags=re.DOTALL)
    paths = [np.array(re.findall(r"-?\d[\d.e-]*", d), float) for d in re.findall(r'\bd="([^"]+)"', shown)]
    return np.array([[p[::2].min(), p[::2].max(), p[1::2].min(), p[1::2].max()] for p in paths])


@pytest.mark.long
def test_the_script_makes_the_drawings_that_pages_show(tmp_path: Path) -> None:
    drawings.main(tmp_path)
    made = {path.name: path.read_text(encoding="utf-8") for path in tmp_path.iterdir()}
    pages = "".join(page.read_text(encoding="utf-8") for page in (ROOT / "docs").rglob("*.md"))
    assert {*made} == {path.name for path in drawings.FOLDER.iterdir()}
    assert {*made} == {*re.findall(r"\]\((?:\.\./)?drawings/(\w+\.svg)\)", pages)}
    for name, drawing in made.items():
        committed = (drawings.FOLDER / name).read_text(encoding="utf-8")
        # matplotlib notes every text as a comment.
        assert re.findall("<!--.*?-->", drawing) == re.findall("<!--.*?-->", committed), name
        np.testing.assert_allclose(extents(drawing), extents(committed), atol=1.0, err_msg=name)


def named(figure: Figure, kind: type, gid: str) -> list:
    return [artist for artist in figure.findobj(kind) if artist.get_gid() == gid]


def way(figure: Figure, gid: str) -> np.ndarray:
    """Return the direction of the arrow with a name."""
    (arrow,) = named(figure, Annotation, gid)
    vector = np.subtract(arrow.xy, arrow.xyann)
    return vector / np.hypot(*vector)


def test_patches_lie_where_the_setup_places_them_and_thicknesses_as_written() -> None:
    setup = cl.build(["placement.start=16 mm", "placement.end=25 mm", "resonator.length=60 mm"])
    figure = drawings.draw_motor(setup)
    for number, (start, end) in ((1, (16.0, 25.0)), (2, (35.0, 44.0))):
        for patch in named(figure, drawings.Rectangle, f"patch_{number}"):
            assert patch.get_x() + 30.0 == pytest.approx(start)
            assert patch.get_x() + patch.get_width() + 30.0 == pytest.approx(end)
            assert patch.get_height() == pytest.approx(drawings.THICKER)
    (tip,) = named(figure, drawings.Polygon, "tip")
    assert tip.get_xy()[:, 1].max() == pytest.approx(1e3 * setup.motor.geometry.tip_length)


def test_a_field_along_the_poling_shortens_the_upper_patch() -> None:
    # Poled down, with the field from the outer electrode down to the beam, the upper layer shrinks along it
    # and bends the beam upwards: the first shape's slope grows from the outer to the inner end of the patch.
    modes = cl.build().motor.modes
    figure = drawings.draw_motor()
    assert all(arrow.xy[1] < arrow.xyann[1] for arrow in named(figure, Annotation, "poling"))
    assert modes.shape_coupling[0] == pytest.approx(modes.shape_coupling[0, 0])
    start, end, root = 0.914 / 57.0, 10.146 / 57.0, 4.730040744862704
    s = (np.cosh(root) - np.cos(root)) / (np.sinh(root) - np.sin(root))
    slope = [np.sinh(x) + np.sin(x) - s * (np.cosh(x) - np.cos(x)) for x in (root * start, root * end)]
    assert np.sign(modes.shape_coupling[0, 0]) == np.sign(slope[1] - slope[0]) == 1.0


def test_drawn_directions_are_those_of_the_engine() -> None:
    figure, pose = drawings.draw_frame(), drawings.shown_pose()
    geometry, step = pose.geometry, 1e-6
    gap, n_u, n_th, t_u, t_th = geometry.frame(pose.u, pose.theta)
    towards = pose.tip - pose.centre
    assert np.hypot(*towards) - geometry.rotor_radius == pytest.approx(gap, rel=1e-12)
    # Where the drawn tip goes with displacement and slope, seen along drawn normal and tangent.
    normal, tangent = pose.directions
    for (u, theta), n, t in (((step, 0.0), n_u, t_u), ((0.0, step), n_th, t_th)):
        moved = (drawings.Pose(pose.u + u, pose.theta + theta, 0.0, geometry).tip - pose.tip) / step
        assert normal @ moved == pytest.approx(n, abs=1e-6)
        assert tangent @ moved == pytest.approx(t, abs=1e-6)
    assert way(figure, "g") == pytest.approx(normal)
    assert normal == pytest.approx(towards / np.hypot(*towards))
    assert way(figure, "u") == pytest.approx([0.0, 1.0])
    # Positive slope and angle are counter-clockwise: the tip goes back, the mark at the bottom goes on.
    assert pose.tip[0] < 0.0
    assert way(figure, "theta")[0] < 0.0 < way(figure, "alpha")[0]
    n, t = (np.array(v) for v in drawings.Pose(0.0, 0.0, 0.0, geometry).directions)
    for name, sign in (("tip", 1.0), ("rotor", -1.0)):
        assert way(figure, f"N on the {name}") == pytest.approx(sign * n)
        assert way(figure, f"F on the {name}") == pytest.approx(sign * t)
    for name in ("tip velocity", "surface velocity", "v"):
        assert way(figure, name) == pytest.approx(t)


def test_gap_slip_and_torque_of_a_run_have_the_drawn_signs() -> None:
    setup = cl.build(["rotor.load_torque=2 mN m"])
    run = cl.simulate(setup, duration=5e-4, record_interval=1e-7)
    names = ("tip_normal_displacement", "tip_slope", "rotor_angle")
    poses = [
        drawings.Pose(*x, setup.motor.geometry) for x in zip(*(run[n].values for n in names), strict=True)
    ]
    tip = np.array([pose.tip for pose in poses])
    tangent = np.array([pose.directions[1] for pose in poses])
    gap = np.hypot(*(tip - poses[0].centre).T) - setup.motor.geometry.rotor_radius
    np.testing.assert_allclose(run["gap"], gap, atol=1e-16)
    # The point of the rim that is at the bottom at rest, a negligible angle from the contact.
    surface = np.array([pose.rim(-90.0) for pose in poses])
    slip = np.sum(tangent * np.gradient(tip - surface, 1e-7, axis=0), axis=1)
    np.testing.assert_allclose(run["slip_velocity"][1:-1], slip[1:-1], atol=2e-4)
    assert np.abs(slip).max() > 0.05
    # J dOmega/dt = -R F - tau, where tau is drawn against Omega, F on the rotor against t.
    figure, rotor = drawings.draw_frame(), setup.motor.rotor
    assert way(figure, "Omega") @ way(figure, "tau") < 0.0
    friction = float(run["friction_force"][1:].sum()) * 1e-7
    turned = -setup.motor.geometry.rotor_radius * friction - rotor.load_torque * 5e-4
    assert rotor.inertia * float(run["rotor_velocity"][-1]) == pytest.approx(turned, rel=1e-9)


def test_drawn_impulses_are_those_of_the_impacts_and_inside_the_cone() -> None:
    run = drawings.impact_run()
    normal, friction = (drawings.impulses_of(run, name) for name in ("normal", "friction"))
    # The force after an impact changes within the record interval.
    np.testing.assert_allclose(normal, run.contacts["largest_impact"], rtol=1e-4)
    share = np.abs(friction) / (0.3 * normal)
    assert share[0] == pytest.approx(1.0, rel=1e-4)
    assert np.all(share[1:] < 0.9)


def test_the_drawn_step_is_collocated_at_radau_nodes_of_the_force_of_the_run() -> None:
    figure = drawings.draw_step()
    (nodes,) = named(figure, drawings.plt.Line2D, "nodes")
    (polynomial,) = named(figure, drawings.plt.Line2D, "polynomial")
    c, force = nodes.get_data()
    # Five nodes with the last at the end have a quadrature of degree 8.
    weights = np.linalg.solve(c ** np.arange(5)[:, None], 1.0 / np.arange(1, 6))
    assert c[-1] == pytest.approx(1.0)
    assert weights @ c**8 == pytest.approx(1.0 / 9.0)
    part = drawings.shown_contact()
    time = part.time - part.contacts["start_time"][0] - 0.5 * drawings.INTERVAL
    recorded = np.interp(c * drawings.STEP_SHOWN, time, part.series["normal_force"])
    np.testing.assert_allclose(force, recorded, atol=0.002 * force.max())
    x, drawn = polynomial.get_data()
    np.testing.assert_allclose(np.polyval(np.polyfit(c, force, 4), x), drawn, atol=1e-9)


def test_the_drawn_memory_loads_and_unloads_along_the_stiffnesses_of_its_law() -> None:
    law = cl.WaltonBraun()
    (line,) = named(drawings.draw_memory(), drawings.plt.Line2D, "yielding")
    depth, force = 1e-6 * line.get_xdata(), line.get_ydata()
    deepest = int(depth.argmax())
    slopes = np.gradient(force, depth)
    assert slopes[deepest - 50] == pytest.approx(law.loading_stiffness, rel=1e-3)
    assert slopes[deepest + 50] == pytest.approx(law.unloading_stiffness, rel=1e-3)
    # No force before the body is back at the surface: k_1 d* = k_2 (d* - d_p).
    dent = depth.max() * (1.0 - law.loading_stiffness / law.unloading_stiffness)
    assert depth[force > 1e-3][-1] == pytest.approx(dent, abs=0.01e-6)


def test_the_drawn_map_has_the_slope_of_its_largest_multiplier_at_the_fixed_point() -> None:
    figure = drawings.draw_map()
    (points,), (fixed,) = (named(figure, drawings.plt.Line2D, name) for name in ("map", "fixed point"))
    (multipliers,) = named(figure, drawings.plt.Line2D, "multipliers")
    largest = np.hypot(*multipliers.get_data()).max()
    x, y = (np.asarray(values) for values in points.get_data())
    slope = (y[-1] - y[-2]) / (x[-1] - x[-2])
    assert slope == pytest.approx(largest**drawings.SKIPPED, rel=0.02)
    assert x[-1] + (y[-1] - x[-1]) / (1.0 - slope) == pytest.approx(float(fixed.get_xdata()[0]), rel=1e-3)


def test_the_bound_of_the_flight_lies_below_its_gap_and_each_module_is_a_layer() -> None:
    (axes,) = drawings.draw_flight().axes
    gap = next(line for line in axes.lines if len(line.get_xdata()) > 2000)
    bounds = [line for line in axes.lines if line.get_gid() == "bound"]
    assert len(bounds) > 3
    for line in bounds:
        assert np.all(line.get_ydata() > 0.0)
        assert np.all(line.get_ydata() <= np.interp(line.get_xdata(), *gap.get_data()) + 1e-6)
    modules = [
        text for text in drawings.draw_data().findobj(drawings.plt.Text) if text.get_gid() == "modules"
    ]
    assert (
        {"engine", "motor", "laws"} <= {m for t in modules for m in t.get_text().split()} <= drawings.layers()
    )


def test_the_drawn_modes_are_those_of_the_motor_at_equal_and_opposite_voltages() -> None:
    modes = cl.build().motor.modes
    first, second, _ = drawings.draw_modes().axes
    # Mode shapes over the tip's height or lean, without a rotor: u and theta of the normal modes.
    for axes, k, motion in ((first, 0, modes.tip_displacement), (second, 1, modes.tip_slope)):
        tip = axes.lines[-1].get_xydata()
        lean = -(tip[1] - tip[0])[0]
        moved = tip[0, 1] if k == 0 else lean
        assert np.sign(moved) == np.sign(motion[k] * modes.coupling[k, 0])
        assert abs(lean) > 5.0 if k else abs(lean) < 1e-9
        equal = modes.coupling[k, 0] * modes.coupling[k, 1] > 0.0
        assert equal == (k == 0)
