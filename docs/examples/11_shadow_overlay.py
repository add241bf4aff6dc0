"""
Shadows on a photographed floor
===============================

Ratios of radiance darken a floor of any colour below a ball and a box: all shadows together, and
those of single lights.
"""

import envlights as el

env = el.EnvMap(el.synthetic.hall(256).radiance)
rig = el.fit(env, lights=4, floor=True)
ball = el.scene.Ball((-0.65, 0.5, 0.1), 0.5)
box = el.scene.Box((0.65, 0.4, -0.1), (0.4, 0.4, 0.4), turn=0.5)
figure = el.plot.overlay_picture(el.scene.shadow_overlay(rig, [ball, box]))
