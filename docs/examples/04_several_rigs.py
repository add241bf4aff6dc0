"""
Several rigs in one picture
===========================

One light, two, and four: the probe under each, and where it is too bright or too dark.
"""

import envlights as el

env = el.EnvMap(el.synthetic.hall(256).radiance)
figure = el.plot.rigs_picture(env, *(el.fit(env, lights=lights) for lights in (1, 2, 4)))
