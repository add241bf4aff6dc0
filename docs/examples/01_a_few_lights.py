"""
A map as a few lights
=====================

``fit`` turns a map into an ambient term and a few lights. The picture has the map with its lights,
a white ball under the map and under the lights, and their difference.
"""

import envlights as el

env = el.EnvMap(el.synthetic.hall(256).radiance)
rig = el.fit(env, lights=4)
print(rig)
figure = el.plot.picture(env, rig)
