"""
The data sheet of a motor
=========================

`cl.characterise` measures what a catalogue tells: torque, power and efficiency over speed, under each law.
`contactlab characterise` writes the same as a page.
"""

import contactlab as cl

sheet = cl.characterise([cl.build([f"law={law}"]) for law in ("hertz_penalty", "lagrange_stick")])
print(sheet)
curves = sheet.plot()
