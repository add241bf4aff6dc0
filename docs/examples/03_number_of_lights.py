"""
The error by the number of lights
=================================

Each ambient term has a curve: none, a constant, and nine spherical harmonics. ``error`` asks for
the fewest lights that reach it.
"""

import envlights as el

env = el.EnvMap(el.synthetic.hall(256).radiance)
rigs = [el.fit(env, error=0.003, ambient=ambient) for ambient in ("none", "constant", "sh2")]
for rig in rigs:
    print(rig.in_short())
figure = el.plot.error_picture(*rigs)
