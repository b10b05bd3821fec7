"""Errors in beam, resonator, materials, drive and geometry."""

from mutation.kinds import Mutation

RESONATOR = "contactlab/resonator"
TABLE = ("tests/test_resonator.py",)
CASE_A = ("tests/test_case_a.py",)

MOTOR = (
    Mutation(
        "the mass of one layer of patches (misprint of eq. 28)",
        RESONATOR,
        "self.piezoceramic.density * 2.0 * self.width",
        "self.piezoceramic.density * 1.0 * self.width",
        TABLE,
    ),
    Mutation(
        "negative tip mass (misprint of eq. 23)",
        RESONATOR,
        "mass += self.tip_mass *",
        "mass -= self.tip_mass *",
        TABLE,
    ),
    Mutation(
        "t_p for t_s in the lever of the coupling",
        RESONATOR,
        "self.width * (self.beam_thickness + self.patch_thickness)",
        "self.width * (self.patch_thickness + self.patch_thickness)",
        TABLE,
    ),
    Mutation(
        "sign of the coupling as printed (eq. 31)",
        RESONATOR,
        "turn = beam.evaluate(end, 1) - beam.evaluate(start, 1)",
        "turn = beam.evaluate(start, 1) - beam.evaluate(end, 1)",
        TABLE,
    ),
    Mutation(
        "tip inertia on the displacement in place of the slope",
        RESONATOR,
        "self.tip_inertia * np.outer(slope, slope)",
        "self.tip_inertia * np.outer(displacement, displacement)",
        TABLE,
    ),
    Mutation(
        "patches stiffen the beam as a layer about its own middle",
        RESONATOR,
        "inertia = 2.0 / 3.0 * self.width * (1.5 * tp**2 * ts + 0.75 * ts**2 * tp + tp**3)",
        "inertia = 2.0 / 12.0 * self.width * (0.0 * ts + tp**3)",
        TABLE,
    ),
    Mutation(
        "mass damping forgotten",
        RESONATOR,
        "damping=self.mass_damping * mass + self.stiffness_damping * stiffness",
        "damping=self.stiffness_damping * stiffness",
        ("tests/test_resonator.py", "tests/test_against_oracle.py"),
    ),
    Mutation(
        "the beam's middle a tenth off",
        RESONATOR,
        "displacement = beam.evaluate(0.5 * self.length)",
        "displacement = beam.evaluate(0.45 * self.length)",
        TABLE,
    ),
    Mutation(
        "steel bends as if it contracted freely",
        "contactlab/materials.py",
        "b = bending_vector(nu)\n        return float(b @ tensor @ b)",
        "return float(self.youngs_modulus)",
        ("tests/test_materials.py",),
    ),
    Mutation(
        "both electrodes driven alike",
        "contactlab/drive.py",
        "[first, -second]",
        "[first, second]",
        ("tests/test_drive.py",),
    ),
    Mutation(
        "phase on the second tone",
        "contactlab/drive.py",
        "second = -1j * voltage_2",
        "second = -1j * voltage_2 * np.exp(1j * phase)",
        ("tests/test_drive.py",),
    ),
    Mutation(
        "second tone at three times the first whatever is asked",
        "contactlab/drive.py",
        "np.array([frequency, frequency_ratio * frequency])",
        "np.array([frequency, 3.0 * frequency])",
        ("tests/test_drive.py",),
    ),
    Mutation(
        "tangent turned the wrong way",
        "contactlab/geometry.py",
        "        nx,\n        tip_length * (cosine * ny - sine * nx),",
        "        -nx,\n        -tip_length * (cosine * ny - sine * nx),",
        ("tests/test_geometry.py",),
    ),
    Mutation(
        "slope of the tip without its length in the gap",
        "contactlab/geometry.py",
        "excess = clearance - u + 2.0 * tip_length * half * half",
        "excess = clearance - u",
        ("tests/test_geometry.py",),
    ),
    Mutation(
        "rotor torque without the radius (misprint of eq. 48)",
        "contactlab/engine/plant.py",
        "-geometry.rotor_radius / root",
        "-1.0 / root",
        ("tests/test_misprints.py", "tests/test_case_a.py"),
    ),
    Mutation(
        "load torque drives in place of braking",
        "contactlab/engine/plant.py",
        "-rotor.load_torque / root",
        "rotor.load_torque / root",
        ("tests/test_misprints.py",),
    ),
    Mutation(
        "rotor damping forgotten",
        "contactlab/engine/plant.py",
        "rotor.damping / rotor.inertia",
        "0.0 * rotor.damping",
        ("tests/test_ledger.py",),
    ),
    Mutation(
        "drive phasors complex conjugate",
        "contactlab/engine/plant.py",
        "force_im=force.imag.copy()",
        "force_im=-force.imag.copy()",
        ("tests/test_against_oracle.py",),
    ),
)
