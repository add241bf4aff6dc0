"""
Few lights on metal
===================

Reflections need more lights than shading and shadows do: errors by the number of lights.
"""

import envlights as el

env = el.EnvMap(el.synthetic.hall(256).radiance)
curve = el.error_curve(env, (1, 2, 4, 8, 16))
print(curve)
figure = el.plot.error_curve(curve)
