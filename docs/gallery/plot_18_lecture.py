"""
Frames for a lecture
====================

A number and what follows from it, a picture for each value, with a slider that the arrow keys move. The text
of ``_repr_html_()`` is a file for any browser, with the pictures in it, that needs no network or Python; a
notebook shows it as it is shown here.
"""

# sphinx_gallery_capture_repr = ("_repr_html_",)
from base64 import b64encode
from io import BytesIO

import matplotlib.pyplot as plt
import numpy as np

import contactlab as cl

SHOW = "[...this.nextElementSibling.children].forEach((x, i) => { x.hidden = i != this.value })"


class Frames:
    """What a function draws on axes, for some values."""

    def __init__(self, draw, values):
        figure, axes = plt.subplots(layout="constrained")
        self.pictures = []
        for value in values:
            axes.clear()
            draw(axes, value)
            file = BytesIO()
            figure.savefig(file, dpi=90, format="png")
            self.pictures.append(b64encode(file.getvalue()).decode())
        plt.close(figure)

    def _repr_html_(self):
        last, style = len(self.pictures) - 1, "width: 100%"
        slider = (
            f'<input type="range" max="{last}" value="0" style="{style}" aria-label="frame" oninput="{SHOW}">'
        )
        image = '<img src="data:image/png;base64,{}" alt="frame {}" style="max-width: 100%"{}>'
        shown = (image.format(each, i, " hidden" if i else "") for i, each in enumerate(self.pictures))
        return f"<div>{slider}<div>{''.join(shown)}</div></div>"


# %%
# **How long does a ball bounce?** From a height h it comes to rest after sqrt(2 h/g) (1 + e)/(1 - e): the
# dashed line.

height, gravity = 0.1, 9.81


def bounce(axes, restitution):
    """Draw the height over time."""
    ball = cl.ball(0.1, height=height, gravity=gravity)
    run = cl.simulate(ball, cl.Newton(restitution=restitution), duration=1.5, record_interval=2e-3)
    rests = np.sqrt(2.0 * height / gravity) * (1.0 + restitution) / (1.0 - restitution)
    axes.plot(run["time"], 1e3 * run["gap"])
    axes.axvline(rests, color="0.4", linestyle="--")
    axes.set(xlabel="time (s)", ylabel="height (mm)", xlim=(0.0, 1.5), ylim=(0.0, 105.0))
    axes.set_title(f"restitution {restitution:.2f}")


Frames(bounce, np.linspace(0.3, 0.8, 11))

# %%
# **When does a slider stick?** A mass on a spring, on a belt, with more friction at rest than in motion: it
# sticks until the spring breaks it loose, and the faster the belt, the more of the time it slides.

falling = cl.Composed(cl.Linear(1e7), friction=cl.Stribeck(0.2, static_ratio=2.0, stribeck_velocity=0.01))


def rub(axes, velocity):
    """Draw the stretch of the spring over time."""
    slider = cl.belt(1.0, 1e3, weight=10.0, belt_velocity=velocity, penetration=1e-6)
    run = cl.simulate(slider, falling, duration=1.2, record_interval=1e-3)
    axes.plot(run["time"], 1e3 * run["tip_tangential_displacement"])
    axes.set(xlabel="time (s)", ylabel="stretch (mm)", xlim=(0.0, 1.2), ylim=(-4.0, 8.0))
    axes.set_title(f"belt {1e3 * velocity:.0f} mm/s")


Frames(rub, [0.005, 0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.15, 0.2])

# %%
# **What does the phase do?** Two voltages drive the motor; their phase shapes the path of its tip, and so the
# speed, here in the steady state.

setup = cl.build(["law=newton"])


def path(axes, phase):
    """Draw the path of the tip over one period."""
    state = cl.orbit(setup.with_({"drive.phase": phase}))
    series = state.series(300)
    across, along = (1e6 * series[f"tip_{way}_displacement"] for way in ("normal", "tangential"))
    axes.plot(along, across)
    axes.set(xlabel="along the rotor (um)", ylabel="towards the rotor (um)")
    axes.set(xlim=(-3.0, 3.0), ylim=(-3.0, 1.5))
    axes.set_title(f"phase {np.degrees(phase):.0f} degrees, {state.velocity.value:.2f} rad/s")


Frames(path, np.radians(np.arange(-90.0, 91.0, 15.0)))
