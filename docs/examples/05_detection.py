"""
Lights that are visible in a map
================================

``detect`` finds the sources themselves, with the outline of their pixels, and says why a pixel is a
light: the threshold is in the printed report.
"""

import envlights as el

env = el.EnvMap(el.synthetic.hard(3, 512).radiance)
lights = el.detect(env)
print(lights)
figure = el.plot.detection_picture(env, lights)
