"""Rigid laws with a restitution, a family a module."""

from contactlab.laws.impact.brach import Brach
from contactlab.laws.impact.chatterjee_ruina import ChatterjeeRuina
from contactlab.laws.impact.johnson import Johnson
from contactlab.laws.impact.newton import MoreauJean, Newton
from contactlab.laws.impact.process import Poisson, Stronge
