"""The verbs of the command: words that may stand first in place of a run."""

VERBS = {
    "animate": "show tip, rotor and contact force of a run in slow motion, as GIF or MP4",
    "collect": "put the runs of a sweep into one dataset over their parameters",
    "compare": "set the contact laws of several runs side by side, judged, drawn and reported",
    "laws": "list every installed law and part, with all that it declares",
    "map": "run a motor over many values of many parameters, and keep numbers instead of records",
    "verify": "print what is claimed of the engine and the laws, and what is found",
}
"""What each does. Its work is `main(arguments)` in the module of its name beside this one."""
