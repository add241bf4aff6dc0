"""
Axes of each program
====================

Our +x (red), +y (green) and +z (blue) with their names in each program. A dashed arrow is where a
program shows the centre of an unrotated map.
"""

import envlights as el

figure = el.plot.axes_picture()
