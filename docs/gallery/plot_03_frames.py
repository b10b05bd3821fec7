"""
A period in pictures
====================

What `contactlab animate` shows as a film, as a strip: the settled motor over one period of its drive. The
tip comes up, sticks to the rotor for a while, slips, and leaves it. Motion is magnified, lengths are true.
"""

import matplotlib.pyplot as plt

import contactlab as cl
from contactlab.plot.animation import Animation
from contactlab.plot.recording import film_of, recording_of

# %%
# The motor runs until it has settled, and then for one period with a record every half microsecond.

settled = cl.simulate(cl.build(), duration=0.2)
period = recording_of(settled.tree).period
run = recording_of(cl.simulate(start=settled, duration=period, record_interval=5e-7).tree)
film = film_of(run, run.start, run.end, 60)

# %%
# Six of sixty frames; grey is free, orange slips, blue sticks, and the arrow is the force on the rotor.

drawing = Animation(film, 10.0)
figure, places = plt.subplots(1, 6, figsize=(7.2, 1.8), layout="constrained")
for axes, number in zip(places.flat, (6, 16, 19, 23, 28, 45), strict=True):
    axes.imshow(drawing.frame(number)[66:384, 275:520])
    axes.set_title(f"{1e6 * (film.time[number] - run.start):.0f} us")
    axes.axis("off")
plt.show()
