"""The data sheet of a motor: what it does on belts and under loads once it has settled."""

from contactlab.datasheet.sheet import characterise as characterise
from contactlab.datasheet.table import as_text as as_text
