from contactlab.config import ConfigurationError as ConfigurationError, Setup as Setup, build as build
from contactlab.driving import drive as drive
from contactlab.engine.equilibrium import at_rest as at_rest
from contactlab.estimate import Estimate as Estimate
from contactlab.force_curves import force_curve as force_curve
from contactlab.impacts import impact as impact, normal_impact as normal_impact
from contactlab.interrupts import StoppedError as StoppedError
from contactlab.laws import (
    AgeingStick as AgeingStick,
    Archard as Archard,
    BoucWen as BoucWen,
    Brach as Brach,
    ChatterjeeRuina as ChatterjeeRuina,
    Cohesive as Cohesive,
    Composed as Composed,
    ContactLaw as ContactLaw,
    Coulomb as Coulomb,
    Dahl as Dahl,
    Damping as Damping,
    Dmt as Dmt,
    ElastoPlastic as ElastoPlastic,
    Flores as Flores,
    ForceTable as ForceTable,
    Friction as Friction,
    HertzElliptic as HertzElliptic,
    HertzPenalty as HertzPenalty,
    HertzPoint as HertzPoint,
    HuntCrossley as HuntCrossley,
    InternalVariable as InternalVariable,
    Iwan as Iwan,
    Jkr as Jkr,
    Johnson as Johnson,
    KuwabaraKono as KuwabaraKono,
    LagrangeAgeing as LagrangeAgeing,
    LagrangeSlip as LagrangeSlip,
    LagrangeStick as LagrangeStick,
    LankaraniNikravesh as LankaraniNikravesh,
    LawError as LawError,
    Line as Line,
    Linear as Linear,
    LinearDamping as LinearDamping,
    Lining as Lining,
    LuGre as LuGre,
    Maugis as Maugis,
    Microslip as Microslip,
    Mindlin as Mindlin,
    MoreauJean as MoreauJean,
    MultiplierLaw as MultiplierLaw,
    Nagata as Nagata,
    Newton as Newton,
    NormalForce as NormalForce,
    PenaltyLaw as PenaltyLaw,
    PerrinRiceZheng as PerrinRiceZheng,
    Poisson as Poisson,
    Prony as Prony,
    RateAndState as RateAndState,
    Regularised as Regularised,
    Ruina as Ruina,
    Stribeck as Stribeck,
    Stronge as Stronge,
    Thornton as Thornton,
    Tsuji as Tsuji,
    TwoState as TwoState,
    Undamped as Undamped,
    WaltonBraun as WaltonBraun,
    hertz_stiffness as hertz_stiffness,
    law as law,
    law_names as law_names,
    tabor_number as tabor_number,
)
from contactlab.laws.bare import friction as friction
from contactlab.motor import (
    Bearing as Bearing,
    Chirp as Chirp,
    ContactGeometry as ContactGeometry,
    Drive as Drive,
    FiniteElementResonator as FiniteElementResonator,
    ModalState as ModalState,
    Motor as Motor,
    NormalModes as NormalModes,
    Piezoceramic as Piezoceramic,
    RitzResonator as RitzResonator,
    Rotor as Rotor,
    Sawtooth as Sawtooth,
    Steel as Steel,
    TwoPhase as TwoPhase,
    Vibration as Vibration,
    Waveform as Waveform,
    add_residual_modes as add_residual_modes,
    ball as ball,
    belt as belt,
    block as block,
    cantilever as cantilever,
    on_bearing as on_bearing,
    oscillator as oscillator,
    reduced as reduced,
    slider as slider,
)
from contactlab.motor.modal import read_modes as read_modes, write_modes as write_modes
from contactlab.motor.table import MeasurementError as MeasurementError
from contactlab.motor.universal import read_universal as read_universal
from contactlab.parameter import Parameter as Parameter
from contactlab.processes import WorkerError as WorkerError
from contactlab.simulation import Solution as Solution, simulate as simulate, warm as warm
from contactlab.steady_state import (
    Attractor as Attractor,
    BrokenOffError as BrokenOffError,
    Converged as Converged,
    NoBranchError as NoBranchError,
    NoPeriodError as NoPeriodError,
    NotSettledError as NotSettledError,
    UnboundedError as UnboundedError,
    attractors as attractors,
    orbit as orbit,
)
from contactlab.studies.basins import Basins as Basins, basins as basins
from contactlab.studies.branch import Branch as Branch, branch as branch
from contactlab.studies.characterise.study import Characterise as Characterise, characterise as characterise
from contactlab.studies.compare.study import (
    Compare as Compare,
    ComparisonError as ComparisonError,
    compare as compare,
)
from contactlab.studies.reading import load as load
from contactlab.studies.response import Response as Response, response as response
from contactlab.studies.steady import Steady as Steady, converged as converged, steady as steady
from contactlab.studies.study import Result as Result, Study as Study
from contactlab.studies.sweep.collection import collect as collect
from contactlab.studies.sweep.study import sweep as sweep
from contactlab.studies.sweep.values import SweepError as SweepError
from contactlab.trajectory import Ending as Ending

__version__: str
