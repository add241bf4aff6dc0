"""Draw a figure for one column of a paper: `python docs/figures/three_panels.py [MAP [OUT]]`.

It has 3.3 x 2 inches and three panels: the map with four lights, a white ball under map and lights
with the difference, and the errors against the number of lights. Without a map, it makes a hall
with three bright windows. The suffix of OUT chooses PNG, PDF or SVG.
"""

import sys
from pathlib import Path

import matplotlib as mpl
from matplotlib.figure import Figure

import envlights as el

#: Width of a column, and height, in inches.
SIZE = 3.3, 2.0
#: Style of the figure: fonts of 6 points, thin lines.
STYLE = {
    "font.size": 6,
    "axes.linewidth": 0.5,
    "axes.titlesize": 6,
    "axes.titlepad": 3,
    "lines.linewidth": 1,
    "lines.markersize": 4.5,
    "xtick.major.width": 0.5,
    "ytick.major.width": 0.5,
    "xtick.major.size": 2,
    "ytick.major.size": 2,
}


def draw(env: el.EnvMap) -> Figure:
    """Draw the three panels."""
    rig = el.fit(env, lights=4)
    curve = el.error_curve(env, lights=(0, 1, 2, 4, 8))
    figure = Figure(figsize=SIZE, dpi=300, layout="constrained")
    figure.get_layout_engine().set(w_pad=0.02, h_pad=0.02)
    left, right = figure.subfigures(1, 2, width_ratios=(1.45, 1))
    panels = left.subplot_mosaic([["map"] * 3, ["truth", "lights", "difference"]])
    axes = right.subplots()
    el.plot.picture(env, rig, ax=list(panels.values()))
    el.plot.error_curve(curve, ax=axes)
    for name, title in (("map", "(a) four lights"), ("truth", "(b) map"), ("lights", "lights")):
        panels[name].set_title(title)
    panels["difference"].set_title("difference")
    axes.set_title("(c) errors")
    axes.set_ylabel("RMS error (%)")
    return figure


if __name__ == "__main__":
    given = dict(enumerate(sys.argv[1:]))
    env = el.EnvMap.open(given[0]) if given else el.EnvMap(el.synthetic.hall(512).radiance)
    out = Path(given.get(1, Path(__file__).with_suffix(".png")))
    with mpl.rc_context(STYLE):
        el.plot.save(draw(env), out)
