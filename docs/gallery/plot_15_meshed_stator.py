"""
A stator from a mesh
====================

A steel beam, clamped at both ends, with an elastic tip in its middle, meshed and assembled with
`scikit-fem <https://scikit-fem.readthedocs.io>`_ in plane stress. Two pairs of forces stand for the
piezoelectric patches. Mass and stiffness matrix become normal modes, and these a motor whose rotor a spring
presses on the tip.
"""

import matplotlib.pyplot as plt
import numpy as np
import skfem
from skfem.helpers import ddot, dot, eye, sym_grad, trace

import contactlab as cl

length, height, depth = 40e-3, 2e-3, 8e-3
tip_width, tip_height = 2e-3, 10e-3
young, poisson, density = 210e9, 0.3, 7850.0

# %%
# The mesh: quadrilaterals of half a millimetre, of a rectangle without what is neither beam nor tip.

across = np.linspace(-0.5 * length, 0.5 * length, 81)
up = np.linspace(0.0, height + tip_height, 25)
block = skfem.MeshQuad.init_tensor(across, up)
x, y = block.p[:, block.t].mean(axis=1)
mesh = block.restrict(np.flatnonzero((y < height) | (np.abs(x) < 0.5 * tip_width)))
basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementQuad2()))


@skfem.BilinearForm
def stiffness(u, v, _):
    """Plane stress."""
    strain = sym_grad(u)
    stress = young / (1 + poisson) * (strain + poisson / (1 - poisson) * eye(trace(strain), 2))
    return depth * ddot(stress, sym_grad(v))


@skfem.BilinearForm
def mass(u, v, _):
    """Consistent mass."""
    return depth * density * dot(u, v)


K, M = stiffness.assemble(basis), mass.assemble(basis)
clamped = basis.get_dofs(lambda p: np.isclose(np.abs(p[0]), 0.5 * length)).all()
free = np.setdiff1d(np.arange(basis.N), clamped)

# %%
# The contact point is the middle of the tip's end. A volt pulls the surface of the beam together between two
# points, left of the tip by the first electrode, right of it by the second.


def at(place: float, above: float, direction: int) -> np.ndarray:
    """Unit vector of the displacement of a node along x (0) or y (1)."""
    node = int(np.argmin(np.hypot(mesh.p[0] - place, mesh.p[1] - above)))
    return np.eye(1, basis.N, int(basis.nodal_dofs[direction, node])).ravel()


pull = 0.15  # N/V
patches = [pull * (at(a, 0.0, 0) - at(b, 0.0, 0)) for a, b in ((-14e-3, -4e-3), (4e-3, 14e-3))]
end = height + tip_height
modes = cl.reduced(
    M[free][:, free],
    K[free][:, free],
    uy=at(0.0, end, 1)[free],
    ux=at(0.0, end, 0)[free],
    coupling=np.stack(patches, axis=1)[free],
    modes=6,
    damping_ratio=0.01,
)
print(np.round(modes.natural_frequency[:6]), "Hz")

# %%
# The first mode lifts the tip, the second swings it. Both electrodes together drive the one, against each
# other the other, at nearly twice the frequency: the paper's drive.

frequency = float(modes.natural_frequency[0])
drive = cl.Drive.two_mode(100.0, 100.0, frequency, phase=-0.6)
motor = cl.Motor(modes, drive, cl.ContactGeometry(1e9, 0.02, 0.0), cl.Rotor(inertia=1e-5))
pressed = cl.on_bearing(motor, cl.Bearing(mass=0.05, preload=2.0, damping=100.0))
run = cl.simulate(pressed, cl.law("hertz_penalty"), duration=0.04, record_interval=1.0 / frequency)

figure, (left, right) = plt.subplots(1, 2, figsize=(7.0, 2.8), width_ratios=(1, 1.3), layout="constrained")
left.triplot(1e3 * mesh.p[0], 1e3 * mesh.p[1], mesh.to_meshtri().t.T, linewidth=0.2, color="0.4")
left.set(xlabel="x (mm)", ylabel="y (mm)", aspect="equal", title="mesh")
right.plot(1e3 * run["time"], run["rotor_velocity"])
right.set(xlabel="time (ms)", ylabel="rotor velocity (rad/s)", title="pressed with 2 N")
plt.show()
