"""
The data sheet of a motor
=========================

`cl.characterise` measures what a catalogue tells: torque, power and efficiency over speed, under each law.
`contactlab characterise` writes the same as a page.
"""

from contactlab.datasheet.figure import draw

import contactlab as cl
from contactlab.datasheet import as_text

sheet = cl.characterise([cl.build([f"law={law}"]) for law in ("hertz_penalty", "lagrange_stick")])
print(as_text(sheet))
curves = draw(sheet)
