"""
A map as a few lights
=====================

One fit, and the probe under the map and under the lights.
"""

import envlights as el

env = el.synthetic.hall(256)
env = el.EnvMap(env.radiance)
rig = el.fit(env, lights=4)
print(rig)
el.plot.picture(env, rig)
