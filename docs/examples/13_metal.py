"""
Few lights on metal
===================

Reflections need more lights than shading and shadows do: errors by the number of lights.
"""

import matplotlib.pyplot as plt

import envlights as el

env = el.EnvMap(el.synthetic.hall(256).radiance)
counts = (1, 2, 4, 8, 16)
rigs = [el.fit(env, lights=count) for count in counts]
figure, axes = plt.subplots(figsize=(6, 4), layout="constrained")
axes.loglog(counts, [100 * rig.error for rig in rigs], "o-", label="shading")
axes.loglog(counts, [100 * rig.report.shadow_error for rig in rigs], "s-", label="shadows")
for roughness in (0.33, 0.5):
    errors = [100 * rig.report.gloss_error(roughness) for rig in rigs]
    axes.loglog(counts, errors, "^-", label=f"metal of roughness {roughness}")
axes.set(xlabel="lights", ylabel="relative error, %", xticks=counts, xticklabels=counts)
axes.legend()
