"""Quantities of a data sheet: names, units and meaning."""

from typing import Final

from contactlab.variables import Variable

POINT: Final = {name: Variable(name, ("point",), *rest) for name, *rest in (
    ("velocity", "rad s-1", "Omega", "velocity in the motor's own sense of rotation"),
    ("velocity_ripple", "rad s-1", "", "largest less smallest velocity of a free rotor, else zero"),
    ("torque", "N m", "M", "load that the rotor carries, -R F - C_r Omega in the motor's sense: a load that "
     "brakes is positive, one that drives it negative"),
    ("output_power", "W", "P_out", "M Omega, to the load; negative where the load puts power in"),
    ("drive_power", "W", "P_d", "work of the drive on the resonator over time"),
    ("damping_power", "W", "P_c", "loss in the resonator's and the rotor's viscous damping"),
    ("friction_power", "W", "P_f", "loss in friction"),
    ("contact_power", "W", "P_n", "loss in normal damping and impacts"),
    ("dielectric_power", "W", "P_e", "loss in the dielectric of the patches"),
    ("balance", "W", "r", "electrical input less output, losses and stored power; the energy balance error"),
    ("mechanical_efficiency", "1", "eta_m", "output power over the power of the drive"),
    ("electrical_efficiency", "1", "eta_e", "output power over active electrical power"),
    ("active_power", "W", "P", "electrical input: power of the drive and of the dielectric loss"),
    ("apparent_power", "V A", "S", "sum over the electrodes of U_rms I_rms, all tones together"),
    ("power_factor", "1", "P/S", "active over apparent power"),
    ("rms_voltage", "V", "U_rms", "voltage, root mean square over time and electrodes"),
    ("rms_current", "A", "I_rms", "current, root mean square over time and electrodes"),
    ("peak_force", "N", "N_max", "largest normal force"),
    ("contact_share", "1", "t_c/T", "share of the time in contact"),
    ("stick_share", "1", "t_st/t_c", "share of the time in contact that sticks"),
    ("friction_work_per_slip", "J m-1", "W_f/s", "friction work per metre of slip"),
    ("friction_work_per_travel", "J m-1", "W_f/x", "friction work per metre that the rotor's rim travels"),
)}  # fmt: skip
"""Quantities of each point of the speed-torque curve."""

MOTOR: Final = {name: Variable(name, (), *rest) for name, *rest in (
    ("no_load_velocity", "rad s-1", "Omega_0", "velocity of the free rotor in the motor's sense"),
    ("curve_root", "rad s-1", "", "velocity at which the speed-torque curve is zero, a check"),
    ("stall_torque", "N m", "M_0", "load that holds the rotor at rest"),
    ("holding_torque", "N m", "M_h", "load that moves the rotor when the drive is off"),
    ("start_time", "s", "t_90", "from the start to 90 % of the no-load velocity"),
    ("stop_time", "s", "t_10", "from the no-load velocity to 10 % of it, the drive switched off and short"),
    ("coasting_velocity", "rad s-1", "", "velocity at which the tip leaves the rotor after switching off"),
)}  # fmt: skip
"""Quantities of a motor."""
