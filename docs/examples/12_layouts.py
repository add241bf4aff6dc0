"""
One map in other layouts
========================

The same radiance as a strip of a cube, as an octahedral square and as a light probe.
"""

import matplotlib.pyplot as plt
import numpy as np

import envlights as el

env = el.EnvMap(el.synthetic.hall(512).radiance)
sizes = {"equirectangular": 256, "cube": 64, "octahedral": 128, "angular": 128}
figure, axes = plt.subplots(2, 2, figsize=(7, 5), layout="constrained")
for panel, (layout, width) in zip(axes.flat, sizes.items(), strict=True):
    pixels = np.asarray(env.to(layout, width=width))
    if layout == "cube":  # six faces, one below the other
        pixels = np.concatenate(np.split(pixels, 6), axis=1)
    panel.imshow(np.clip(pixels, 0, 1) ** (1 / 2.2))
    panel.set_title(layout)
    panel.axis("off")
