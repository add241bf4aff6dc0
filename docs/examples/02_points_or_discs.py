"""
Points or discs
===============

A light of the fit has a size. Points cast hard shadows; discs cast the soft shadows of windows. A
ball and a box on a floor, in closed form: four points, and four discs.
"""

import envlights as el

env = el.EnvMap(el.synthetic.hall(256).radiance)
points = el.fit(env, lights=4, sizes=False, floor=True)
discs = el.fit(env, lights=4, floor=True)
for rig in (points, discs):
    print(f"{rig.report.shadow_error:.1%} error of shadows")
figure = el.plot.scene(env, points, discs, renderer="closed form")
