"""A metric of every run: how often the tip touches."""

from contactlab.metrics import metric


@metric("f_c", "contacts per second", "s-1", usual=True)
def contact_rate(run):
    return run.contacts("start_time").size / (run.time[-1] - run.time[0])
