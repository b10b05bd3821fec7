"""What a mutation is, and all of them."""

from mutation.of_contact import CONTACT
from mutation.of_engine import ENGINE
from mutation.of_motor import MOTOR
from mutation.of_parts import PARTS

MUTATIONS = (*MOTOR, *CONTACT, *ENGINE, *PARTS)
