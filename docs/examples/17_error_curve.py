"""
Errors by number of lights, for a paper
=======================================

``error_curve`` fits each number of lights. The printed table has errors in percent, the CSV has
them as fractions. The picture fits a column of 3.3 inches.
"""

import envlights as el

env = el.EnvMap(el.synthetic.hall(256).radiance)
curve = el.error_curve(env, (1, 2, 4, 8))
print(curve)
print(curve.to_csv())
figure = el.plot.error_curve(curve, figsize=(3.3, 2.2))
