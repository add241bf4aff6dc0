"""
Lights of a clipped map
=======================

A map of 8 bits has lost the radiance above white. Its lights are then separated by the depth of the
clipped regions, and each has an uncertainty of its direction.
"""

import numpy as np

import envlights as el

radiance = el.synthetic.hall(256).radiance
white = np.quantile(radiance.max(axis=2), 0.97)
codes = np.round(255 * np.minimum(radiance / white, 1) ** (1 / 2.2)).astype(np.uint8)
env = el.EnvMap(codes)
lights = el.detect(env)
print(lights)
figure = el.plot.plateau_picture(env, lights)
