"""
The sun of an 8-bit panorama
============================

A picture of the sky is white for degrees around its sun. ``find_sun`` estimates where the sun is
and how bright, and the fit takes it as one of its lights.
"""

import numpy as np

import envlights as el

truth = el.synthetic.clear_sky(256).radiance
white = np.quantile(truth.max(axis=2), 0.98)
codes = np.round(255 * np.minimum(truth / white, 1) ** (1 / 2.2)).astype(np.uint8)
env = el.EnvMap(codes)
print(el.find_sun(env))
figure = el.plot.sun(env)
