"""Rigid laws with a restitution, a family a module."""

from contactlab.laws.impact.newton import MoreauJean, Newton
from contactlab.laws.impact.process import Poisson, Stronge
