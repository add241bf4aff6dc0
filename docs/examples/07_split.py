"""
A map without its lights
========================

``split`` takes the lights out of a map and fills their pixels from around them. Lights and
remainder together are the map again.
"""

import envlights as el

env = el.EnvMap(el.synthetic.hall(256).radiance)
lights, remainder = parts = el.split(env)
print(parts)
figure = el.plot.split_picture(env, parts)
