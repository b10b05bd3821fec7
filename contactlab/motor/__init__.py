"""What moves: a resonator in one of several bases, its drive, the tip and the rotor."""

from contactlab.motor.bearing import Bearing, on_bearing
from contactlab.motor.bodies import ball, belt, block, cantilever, oscillator, slider
from contactlab.motor.drive import Chirp, Drive, TwoMode, TwoPhase
from contactlab.motor.finite_element import FiniteElementResonator
from contactlab.motor.geometry import ContactGeometry
from contactlab.motor.motion import Sawtooth, Vibration
from contactlab.motor.motor import ModalState, Motor, NormalModes, Rotor
from contactlab.motor.patched_beam import PatchedBeam, Piezoceramic, PiezoceramicDatasheet, Steel
from contactlab.motor.reduction import reduced
from contactlab.motor.residual import add_residual_modes
from contactlab.motor.ritz import RitzMatrices, RitzResonator
from contactlab.motor.waveform import Waveform

__all__ = [
    "Bearing",
    "Chirp",
    "ContactGeometry",
    "Drive",
    "FiniteElementResonator",
    "ModalState",
    "Motor",
    "NormalModes",
    "PatchedBeam",
    "Piezoceramic",
    "PiezoceramicDatasheet",
    "RitzMatrices",
    "RitzResonator",
    "Rotor",
    "Sawtooth",
    "Steel",
    "TwoMode",
    "TwoPhase",
    "Vibration",
    "Waveform",
    "add_residual_modes",
    "ball",
    "belt",
    "block",
    "cantilever",
    "on_bearing",
    "oscillator",
    "reduced",
    "slider",
]
