"""
The steps of Loghin (2021)
==========================

The method of the article: bright samples, a link between neighbours, and one light for each group.
"""

import envlights as el

env = el.EnvMap(el.synthetic.hall(256).radiance)
print(el.papers.loghin.detect(env))
figure = el.plot.loghin_picture(env)
