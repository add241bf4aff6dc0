"""
Lights on the sphere of directions
==================================

The sphere is seen from outside, from the side of the brightest light and from the opposite side.
"""

import envlights as el

env = el.EnvMap(el.synthetic.hall(256).radiance)
figure = el.plot.sphere_picture(env, el.fit(env, lights=4).lights)
