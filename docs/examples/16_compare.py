"""
Comparison of a map and a rig
=============================

The errors of a guess on three spheres, between lights, and of shading and shadows.
"""

import envlights as el

env = el.EnvMap(el.synthetic.hall(256).radiance)
few = el.fit(env, lights=2)
print(el.compare(env, few))
figure = el.plot.rigs_picture(env, few)
