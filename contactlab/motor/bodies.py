"""Small plants, each a `Motor`: a ball, an oscillator with a stop, a mass on a belt, a cantilever, a slider.

What a ball, a block or a slider meets may move; the numbers of every plant are keys, `plant.mass`.

Beside them a body whose motion is prescribed, for `contactlab.drive`.

The tip is the body, and the rotor the plate, stop or belt that it meets: tip length and radius are so large
that the contact is flat. So the gap is what is between the two, and the slip velocity that of the body's
surface along the other's.
"""

from dataclasses import replace
from math import sqrt
from typing import Annotated, Any, Final, TypeAlias

import numpy as np
import scipy

from contactlab.arrays import Array
from contactlab.checks import check_kind, check_shape
from contactlab.motor.drive import Drive
from contactlab.motor.geometry import ContactGeometry
from contactlab.motor.motion import FOREVER, Motion, drive_of, force_of, together
from contactlab.motor.motor import BELT, FLAT as FLAT, ModalState, Motor, NormalModes, Rotor
from contactlab.motor.patched_beam import Steel
from contactlab.motor.plant import plant
from contactlab.motor.waveform import Waveform
from contactlab.parameter import Parameter, positive

PRESCRIBED_ROOT: Final = 1e20
"""Root of the mass of a body that is led along a path [kg^1/2]: no force changes its motion."""

CLOSED: Final = 1e-15
"""Share of a gap that round-off leaves of it [1]; a rigid contact must not overlap."""

HEAVY: Final = PRESCRIBED_ROOT**2
"""Mass of a belt that nothing brakes [kg]."""

MOST_MODES: Final = 20
"""Of a cantilever: beyond, a Bernoulli-Euler beam is none."""


Mass: TypeAlias = Annotated[float, positive("m", "kg", "mass")]
Stiffness: TypeAlias = Annotated[float, Parameter("k", "N m-1", "stiffness of the spring")]
Dashpot: TypeAlias = Annotated[float, Parameter("c", "N s m-1", "dashpot")]
Frequency: TypeAlias = Annotated[float, positive("f", "Hz", "frequency")]
Gap: TypeAlias = Annotated[float, Parameter("g_0", "m", "gap at rest")]
Penetration: TypeAlias = Annotated[float, Parameter("", "m", "penetration at the start")]
Displacement: TypeAlias = Annotated[float, Parameter("x", "m", "displacement at the start")]
Velocity: TypeAlias = Annotated[float, Parameter("v", "m s-1", "velocity at the start")]


def way_of(theta: Array) -> Array:
    """Return the way along the belt [m] of a recorded tip slope."""
    return np.asarray(-FLAT * np.sin(theta))


def _belt(mass: float = HEAVY, velocity: float = 0.0) -> Rotor:
    """Return a belt of a mass [kg] and a velocity along the way [m/s]."""
    return Rotor(inertia=mass * FLAT**2, initial_velocity=velocity / FLAT)


def _tone(amplitude: float, frequency: float) -> Drive:
    """Return a force or acceleration A cos(2 pi f t), or none."""
    if amplitude == 0.0:
        return Drive()
    return Drive(np.array([frequency]), np.array([[amplitude], [0.0]], dtype=complex))


@plant
def block(
    mass: Mass = 1.0,
    *,
    height: Annotated[float, Parameter("h", "m", "gap at the start")] = 0.0,
    gap_rate: Annotated[float, Parameter("", "m s-1", "rate of the gap at the start")] = 0.0,
    way: Displacement = 0.0,
    velocity: Velocity = 0.0,
    weight: Annotated[float, Parameter("N", "N", "force towards the surface")] = 0.0,
    push: Annotated[float, Parameter("P", "N", "force along the surface")] = 0.0,
    normal_stiffness: Annotated[float, Parameter("k_n", "N m-1", "stiffness of the spring across")] = 0.0,
    stiffness: Stiffness = 0.0,
    normal_damping: Annotated[float, Parameter("c_n", "N s m-1", "dashpot across")] = 0.0,
    damping: Dashpot = 0.0,
    push_amplitude: Annotated[float, Parameter("", "N", "amplitude of the push")] = 0.0,
    push_frequency: Frequency = 1.0,
    belt_mass: Annotated[float, positive("M", "kg", "mass of the belt")] = HEAVY,
    belt_velocity: Annotated[float, Parameter("V", "m s-1", "velocity of the belt at the start")] = 0.0,
    load_velocity: Waveform | None = None,
    base: Motion | None = None,
    table: Motion | None = None,
    touching: bool = False,
) -> Motor:
    """Return a block over a belt: two rigid-body modes, one normal and one along the belt.

    What the block lies on may be shaken: `base` is its displacement along the belt, `table` that across it.
    The block is then seen from there: gap and slip are what they are, ways, heights and energies those over
    the base, and what drives is inertia, -m zdd. `point_base` and `point_table`, the displacements, and
    `point_body`, the block's way over the ground, are recorded. Springs are at rest where the motion begins.

    Args:
        mass: m [kg].
        height, gap_rate: gap [m] and its rate [m/s] at the start; a negative height is pressed in.
        way, velocity: along the belt at the start [m], [m/s].
        weight, push: constant forces towards the belt and along it [N].
        normal_stiffness, stiffness: of springs that pull the block to a gap and a way of zero [N/m].
        normal_damping, damping: of dashpots between block and ground across and along the belt [N s/m].
        push_amplitude, push_frequency: force along the belt, P cos(2 pi f t) [N], [Hz].
        belt_mass, belt_velocity: by default one that nothing brakes [kg]; along the way [m/s].
        load_velocity: of the load point, the far end of the spring along the belt, which begins at a way of
            zero [m/s]: one row, not periodic, and zero outside of its pieces; it may jump. None stands still.
        base: displacement of the belt along itself beside its velocity: shaken ground, inertia drive.
        table: displacement of the belt towards the block: vibrating table, moving wall.
        touching: whether a height in the neck of an adhesive law is in it, see `ModalState`.

    Example:
        A load point that goes ten times as fast after a second, on friction with rate and state:

        >>> import contactlab as cl
        >>> import numpy as np
        >>> from scipy.interpolate import PPoly
        >>> velocity = cl.Waveform(PPoly(np.array([[[1e-5], [1e-4]]]), np.array([0.0, 1.0, 2.0])))
        >>> slider = cl.block(1.0, weight=10.0, stiffness=1e7, load_velocity=velocity)

        Ground that is shaken by an acceleration, under 50 kg:

        >>> shaken = cl.Waveform(PPoly(np.array([[[4.9], [-4.9]]]), np.array([0.0, 0.4, 0.8])))
        >>> ground = shaken.integral().integral()
        >>> lying = cl.block(50.0, weight=490.0, base=ground)
        >>> law = cl.LagrangeStick(friction_coefficient=0.2)
        >>> f"{cl.simulate(lying, law, duration=1.0)['point_body'][-1]:.3f} m"
        '0.620 m'
    """
    root = sqrt(mass)
    drive = _tone(push_amplitude, push_frequency)
    if load_velocity is not None:
        drive = replace(drive, waveform=_pull(load_velocity, stiffness))
    modes = NormalModes(
        stiffness=np.array([normal_stiffness, stiffness]) / mass,
        damping=np.array([normal_damping, damping]) / mass,
        coupling=np.array([[0.0, 0.0], [1.0 / root, 0.0]]),
        # u falls with the gap, and the way is -FLAT sin(theta).
        tip_displacement=np.array([1.0 / root, 0.0]),
        tip_slope=np.array([0.0, -1.0 / (FLAT * root)]),
    )
    motor = Motor(
        modes=modes,
        drive=drive,
        geometry=ContactGeometry(FLAT, FLAT, 0.0),
        rotor=_belt(belt_mass, belt_velocity),
        preload=np.array([weight, push]) / root,
        start=ModalState(root * np.array([-height, way]), root * np.array([-gap_rate, velocity]), touching),
    )
    if base is not None:
        motor = _on_moving(motor, "base", base, 1, -1.0)
    return motor if table is None else _on_moving(motor, "table", table, 0, 1.0)


def _on_moving(motor: Motor, name: str, motion: Motion, mode: int, sign: float) -> Motor:
    """Return a body as it is seen from what it lies on, which is displaced by z(t), less its z at t = 0.

    The coordinate q of the body's mode becomes q' = q + s sqrt(m) z, and what acts on it
    s sqrt(m) (zdd + c zd + k z): no impact is one with a body that is led, so that the ledger closes in all.
    z is a prescribed coordinate that meets no contact, for the sake of its record.

    Args:
        motor: with a start and a preload.
        name: of the motion and of its record.
        motion: z [m] over time.
        mode: that is displaced against what the body lies on.
        sign: s.
    """
    modes, start, preload = motor.modes, motor.start, motor.preload
    assert start is not None
    assert preload is not None
    drive, stiffness, damping = drive_of(name, motion), modes.stiffness[mode], modes.damping[mode]
    place, speed = (float(drive.voltage(0.0, order)[0]) for order in (0, 1))
    # sqrt(m), as a displacement of 1 m of the body is sqrt(m) of its mode.
    row = np.maximum(np.abs(modes.approach), np.abs(FLAT * modes.tip_slope))[mode]
    scale = sign / row
    count = modes.stiffness.size
    shared = np.zeros((count, 1))
    shared[mode] = scale
    constant = preload - (scale * stiffness * place) * (np.arange(count) == mode)
    # The block's velocity along the base is that over the ground, its gap's rate that over the table.
    velocity = start.velocity + (scale * speed if sign < 0.0 else 0.0) * (np.arange(count) == mode)
    points = {key: np.append(values, 0.0) for key, values in modes.points.items()}
    points[name] = np.append(np.zeros(count), 1.0)
    if sign < 0.0:
        points["body"] = np.append(row * (np.arange(count) == mode), 1.0)
    return replace(
        motor,
        modes=replace(
            modes,
            stiffness=np.append(modes.stiffness, 0.0),
            damping=np.append(modes.damping, 0.0),
            coupling=scipy.linalg.block_diag(np.hstack([modes.coupling, shared]), 1.0),
            tip_displacement=np.append(modes.tip_displacement, 0.0),
            tip_slope=np.append(modes.tip_slope, 0.0),
            prescribed=np.append(modes.is_prescribed, True),
            points=points,
        ),
        drive=together(motor.drive, force_of(drive, stiffness, damping), drive),
        preload=np.append(constant, 0.0),
        start=replace(
            start, displacement=np.append(start.displacement, 0.0), velocity=np.append(velocity, 0.0)
        ),
    )


def _pull(load_velocity: Waveform, stiffness: float) -> Waveform:
    """Return the force k x of a load point that goes a way x at a velocity and then rests, and no other."""
    check_kind("load_velocity", load_velocity, Waveform)
    if not stiffness > 0.0:
        raise ValueError(f"stiffness is {stiffness}; it must be positive under a load_velocity.")
    velocity = load_velocity.pieces
    check_shape("load_velocity.pieces.c", velocity.c, (-1, velocity.x.size - 1, 1), "one row")
    if load_velocity.periodic:
        raise ValueError("load_velocity is periodic; it must not be: its way grows from turn to turn.")
    way: Any = velocity.antiderivative()
    # In a last piece it rests.
    force = np.zeros((len(way.c), way.x.size, 2))
    force[:, :-1, :1] = stiffness * way.c
    force[-1, -1, 0] = stiffness * way(way.x[-1])[0]
    edges = np.append(way.x, way.x[-1] + FOREVER)
    return Waveform(scipy.interpolate.PPoly.construct_fast(force, edges), start=load_velocity.start)


def led_body(path: Waveform, gap: bool, touching: bool = False) -> Motor:
    """Return a body that is led along a plate: its slip by a path's second row, its gap or load by the first.

    Args:
        path: two rows: gap [m] or normal force [N], and way along the plate [m].
        gap: whether the first row is the gap. Else it is a force that presses a kilogram on the plate.
        touching: as of `ModalState`.
    """
    across = PRESCRIBED_ROOT if gap else 1.0
    modes = NormalModes(
        stiffness=np.zeros(2),
        damping=np.zeros(2),
        coupling=np.diag([-across if gap else 1.0, PRESCRIBED_ROOT]),
        # As of a block.
        tip_displacement=np.array([1.0 / across, 0.0]),
        tip_slope=np.array([0.0, -1.0 / (FLAT * PRESCRIBED_ROOT)]),
        prescribed=np.array([gap, True]),
    )
    displacement, velocity = (modes.coupling @ path.voltage(0.0, order) for order in (0, 1))
    geometry, plate = ContactGeometry(FLAT, FLAT, 0.0), _belt()
    if not gap:
        # A load is no displacement. It presses from the start on: the gap that the way has opened is closed
        # but for round-off, and the least approach is a contact.
        opened = geometry.frame(0.0, float(modes.tip_slope[1] * displacement[1]))[0]
        displacement[0], velocity[0] = (1.0 - CLOSED) * opened, np.finfo(float).tiny
    return Motor(
        modes, Drive(waveform=path), geometry, plate, start=ModalState(displacement, velocity, touching)
    )


@plant
def ball(
    mass: Mass = 1.0,
    *,
    height: Annotated[float, Parameter("h", "m", "gap at the start")] = 0.0,
    speed: Annotated[float, Parameter("", "m s-1", "speed towards the plate at the start")] = 0.0,
    velocity: Velocity = 0.0,
    spin: Annotated[float, Parameter("R omega", "m s-1", "slip of the rotation at the start")] = 0.0,
    gyration: Annotated[float, positive("I/(m R^2)", "1", "moment of inertia over that of a hoop")] = 0.4,
    gravity: Annotated[float, Parameter("g", "m s-2", "gravity")] = 9.81,
    damping: Dashpot = 0.0,
    table: Motion | None = None,
) -> Motor:
    """Return a ball over a plate, which moves in a plane and may spin in it.

    The plate may be a vibrating table, as of `block`; its displacement is recorded as `point_table`.

    Its Delassus matrix is diagonal, D_nn = 1/m and D_tt = (1 + 1/gyration)/m: 3.5/m of a solid sphere.

    Args:
        mass: m [kg].
        height, speed: gap [m] and speed towards the plate [m/s] at the start.
        velocity: of the centre along the plate at the start [m/s].
        spin: what the rotation adds to the slip at the start, radius times angular velocity [m/s].
        gyration: I / (m R^2) [1]: 2/5 of a solid sphere, 2/3 of a thin shell, 1/2 of a disc.
        gravity: g [m/s^2].
        damping: of a dashpot between the centre and the ground along the plate, and between spin and ground
            at the radius [N s/m]: without it a ball that rolls never stops.
        table: displacement of the plate towards the ball.

    Example:
        >>> import contactlab as cl
        >>> fall = cl.simulate(cl.ball(0.1, height=0.01), cl.Newton(restitution=0.8), duration=0.06)
        >>> [round(float(speed), 3) for speed in fall.contacts.separation_velocity[:1]]
        [0.354]
    """
    root, turning = sqrt(mass), sqrt(gyration * mass)
    modes = NormalModes(
        stiffness=np.zeros(3),
        damping=damping / np.array([np.inf, mass, gyration * mass]),
        coupling=np.zeros((3, 2)),
        tip_displacement=np.array([1.0 / root, 0.0, 0.0]),
        tip_slope=np.array([0.0, -1.0 / (FLAT * root), -1.0 / (FLAT * turning)]),
    )
    motor = Motor(
        modes=modes,
        geometry=ContactGeometry(FLAT, FLAT, 0.0),
        rotor=_belt(),
        preload=np.array([root * gravity, 0.0, 0.0]),
        start=ModalState(
            np.array([-root * height, 0.0, 0.0]), np.array([root * speed, root * velocity, turning * spin])
        ),
    )
    return motor if table is None else _on_moving(motor, "table", table, 0, 1.0)


@plant
def oscillator(
    mass: Mass = 1.0,
    stiffness: Stiffness = 1.0,
    *,
    damping: Dashpot = 0.0,
    gap: Gap = 0.0,
    force: Annotated[float, Parameter("F", "N", "amplitude of the force")] = 0.0,
    frequency: Frequency = 1.0,
    displacement: Displacement = 0.0,
    velocity: Velocity = 0.0,
) -> Motor:
    """Return an oscillator with a stop, m xdd + c xd + k x = F cos(2 pi f t) and x <= gap until it touches.

    Nothing slides: the friction of a law has no say.

    Args:
        mass, stiffness, damping: m [kg], k [N/m] and c [N s/m].
        gap: from the mass at rest to the stop [m]; negative for a compliant law only, that it presses on.
        force, frequency: F [N] and f [Hz].
        displacement, velocity: x [m] and xd [m/s] at the start, positive towards the stop.

    Example:
        >>> import contactlab as cl
        >>> beating = cl.oscillator(1.0, 1e4, gap=1e-4, force=5.0, frequency=12.0)
        >>> run = cl.simulate(beating, cl.Newton(restitution=0.7), duration=0.5, record_interval=1e-4)
        >>> run.complete
        True
    """
    root = sqrt(mass)
    modes = NormalModes(
        # Along the stop the mass rests; damping there leaves no direction of its orbits neutral.
        stiffness=np.array([stiffness, 0.0]) / mass,
        damping=np.array([damping, sqrt(abs(stiffness) * mass)]) / mass,
        coupling=np.array([[1.0 / root, 0.0], [0.0, 0.0]]),
        tip_displacement=np.array([1.0 / root, 0.0]),
        tip_slope=np.array([0.0, -1.0 / (FLAT * root)]),
    )
    return Motor(
        modes=modes,
        drive=_tone(force, frequency),
        geometry=ContactGeometry(FLAT, FLAT, gap),
        rotor=_belt(),
        start=ModalState(root * np.array([displacement, 0.0]), root * np.array([velocity, 0.0])),
    )


@plant
def belt(
    mass: Mass = 1.0,
    stiffness: Stiffness = 1.0,
    *,
    weight: Annotated[float, Parameter("N", "N", "force towards the surface")] = 1.0,
    belt_velocity: Annotated[float, Parameter("V", "m s-1", "velocity of the belt at the start")] = 0.1,
    belt_mass: Annotated[float | None, positive("M", "kg", "mass of the belt")] = None,
    penetration: Penetration = 0.0,
    displacement: Displacement = 0.0,
    velocity: Velocity = 0.0,
) -> Motor:
    """Return a mass that a spring holds on a moving belt, m xdd + k x = friction.

    Args:
        mass, stiffness: m [kg] and k [N/m] of the spring along the belt.
        weight: force that presses the mass on the belt [N].
        belt_velocity: at the start [m/s].
        belt_mass: [kg]; None is `BELT` m, which friction hardly brakes.
        penetration: at the start [m]: under a compliant law that of its balance with the weight, else the
            mass bounces; 0 under a rigid one.
        displacement, velocity: x [m] and xd [m/s] at the start.

    Example:
        >>> import contactlab as cl
        >>> rubbing = cl.belt(1.0, 1e3, weight=10.0, belt_velocity=1.0)
        >>> law = cl.LagrangeStick(friction_coefficient=0.3)
        >>> run = cl.simulate(rubbing, law, duration=0.02, contact_step=1e-5)
        >>> round(float(run["friction_force"][-1]), 2)
        3.0
    """
    return block(
        mass,
        height=-penetration,
        way=displacement,
        velocity=velocity,
        weight=weight,
        stiffness=stiffness,
        belt_mass=BELT * mass if belt_mass is None else belt_mass,
        belt_velocity=belt_velocity,
    )


@plant
def slider(
    mass: Mass = 1.0,
    *,
    tip: Motion,
    weight: Annotated[float, Parameter("N", "N", "force towards the surface")] = 1.0,
    load: Annotated[float, Parameter("P", "N", "load, positive brakes")] = 0.0,
    damping: Dashpot = 0.0,
    normal_damping: Annotated[float, Parameter("c_n", "N s m-1", "dashpot across")] = 0.0,
    velocity: Velocity = 0.0,
    penetration: Penetration = 0.0,
) -> Motor:
    """Return a slider that is pressed on a driven tip, m dv/dt = F - c v - P: an inertia drive.

    The slider is the rotor, of a radius of 1 m: its velocity in rad/s is that of the slider in m/s, and a
    torque in N m the force in N. The tip's end is straight, so that a way x changes the gap by x^2 / 2 m.

    Args:
        mass: m of the slider [kg].
        tip: displacement of the tip along the slider.
        weight: force that presses the slider on the tip [N].
        load: P, which brakes positive motion and drives negative [N].
        damping, normal_damping: of dashpots between slider and ground along the tip's way, c, and across it
            [N s/m].
        velocity: of the slider at the start [m/s].
        penetration: at the start [m]: as of `belt`.

    Example:
        The slow flank takes the slider along, the fast one slips under it:

        >>> import contactlab as cl
        >>> driven = cl.slider(0.01, tip=cl.Sawtooth("1 um", "1 kHz"), weight=1.0)
        >>> state = cl.steady(driven, cl.LagrangeStick(friction_coefficient=0.3))
        >>> f"{1e3 * state.velocity.value:.3f} mm/s"
        '0.767 mm/s'
    """
    root, led = sqrt(mass), drive_of("tip", tip)
    return Motor(
        modes=NormalModes(
            stiffness=np.zeros(2),
            damping=np.array([normal_damping / mass, 0.0]),
            coupling=np.array([[0.0], [PRESCRIBED_ROOT]]),
            tip_displacement=np.zeros(2),
            tip_slope=np.array([0.0, -1.0 / (FLAT * PRESCRIBED_ROOT)]),
            rotor_displacement=np.array([-1.0 / root, 0.0]),
            prescribed=np.array([False, True]),
            points={"tip": np.array([0.0, 1.0 / PRESCRIBED_ROOT])},
        ),
        drive=led,
        geometry=ContactGeometry(FLAT, 1.0, 0.0),
        rotor=Rotor(mass, damping, load, velocity),
        preload=np.array([weight / root, 0.0]),
        start=ModalState(np.array([root * penetration, 0.0]), np.zeros(2)),
    )


@plant
def cantilever(
    length: Annotated[float, positive("L", "m", "length")] = 0.1,
    width: Annotated[float, positive("b", "m", "width")] = 0.01,
    thickness: Annotated[float, positive("h", "m", "thickness")] = 1e-3,
    *,
    material: Steel | None = None,
    modes: Annotated[int, Parameter("", "1", "number of bending modes", at_least=1, at_most=MOST_MODES)] = 4,
    damping_ratio: Annotated[float, Parameter("zeta", "1", "damping ratio of each mode")] = 0.0,
    gap: Gap = 0.0,
    acceleration: Annotated[float, Parameter("a", "m s-2", "amplitude of the shaken clamp")] = 0.0,
    frequency: Frequency = 1.0,
    deflection: Annotated[float, Parameter("", "m", "deflection of the end at the start")] = 0.0,
) -> Motor:
    """Return a clamped beam whose end strikes a stop below it, in its exact bending modes.

    Bernoulli-Euler: cos(b) cosh(b) = -1, omega = (b/L)^2 sqrt(E I / (rho A)). The lower edge of the end is
    what touches, so that its rotation rubs along the stop.

    Args:
        length, width, thickness: [m], the thickness along the bending.
        material: a `Steel`, or any other by its numbers; None is steel.
        modes: number of bending modes [1].
        damping_ratio: of every mode [1].
        gap: from the straight beam's end to the stop [m].
        acceleration, frequency: of clamp and stop, which are shaken as one: a cos(2 pi f t), positive from
            the beam to the stop [m/s^2], [Hz].
        deflection: of the end towards the stop at the start [m], in the first mode.

    Example:
        >>> import contactlab as cl
        >>> beam = cl.cantilever(gap=1e-4, deflection=-1e-3)
        >>> round(float(beam.modes.natural_frequency[0]), 2)
        83.55
        >>> run = cl.simulate(beam, cl.HertzPenalty(stiffness=1e9), duration=0.01, record_interval=1e-5)
        >>> run.contacts.sizes["contact"] > 0
        True
    """
    steel = Steel() if material is None else material
    mass = steel.density * width * thickness * length
    rigidity = steel.youngs_modulus * width * thickness**3 / 12.0
    number, ratio = _clamped_free(modes)
    omega = number**2 * sqrt(rigidity / (mass * length**3))
    # Shapes of int phi^2 dx = L with phi(L) = 2: over the root of the mass they are orthonormal.
    end = np.full(modes, 2.0 / sqrt(mass))
    carried = np.where(np.arange(modes) % 2 == 0, 2.0, -2.0) * ratio / number
    start = np.zeros(modes)
    start[0] = deflection / end[0]
    return Motor(
        NormalModes(
            stiffness=omega**2,
            damping=2.0 * damping_ratio * omega,
            coupling=np.column_stack([-sqrt(mass) * carried, np.zeros(modes)]),
            tip_displacement=end,
            tip_slope=end * ratio * number / length,
        ),
        drive=_tone(acceleration, frequency),
        geometry=ContactGeometry(0.5 * thickness, FLAT, gap),
        rotor=_belt(),
        start=ModalState(start, np.zeros(modes)),
    )


def _clamped_free(count: int) -> tuple[Array, Array]:
    """Return b = beta L of a clamped-free beam, and sigma = (sinh b - sin b) / (cosh b + cos b).

    With phi = cosh z - cos z - sigma (sinh z - sin z), whose int phi^2 dx is L, |phi(L)| = 2, phi'(L) is
    sigma beta phi(L), and int phi dx = 2 sigma / beta.
    """

    def characteristic(z: float) -> float:
        return float(np.cos(z) + 1.0 / np.cosh(z))

    centres = [(i + 0.5) * np.pi for i in range(count)]
    root = scipy.optimize.brentq
    b = np.array([root(characteristic, c - 0.5, c + 0.5, xtol=1e-15) for c in centres])
    small = np.exp(-b)
    ratio = (1.0 - small**2 - 2.0 * small * np.sin(b)) / (1.0 + small**2 + 2.0 * small * np.cos(b))
    return b, ratio
