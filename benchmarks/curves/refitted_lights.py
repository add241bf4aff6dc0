"""A few lights with an ambient term: run time against errors, all peers with the probe of a fit.

Each peer has what `fit` has: an ambient term, radiances that are not negative, and the probe of the
reduced map, in 2 ms. k-means and median cut choose directions, and non-negative least squares
(NNLS) the radiances. SciPy's `least_squares` fits discs and spherical Gaussians with numerical
derivatives from the clusters of k-means, and points from even directions, with the derivatives of
the paper. JAXopt has the same start, and squares instead of bounds; a light without radiance keeps
none, because squares have no gradient there. A peer is called better only if it has no more lights
than ours; a spherical Gaussian counts as a light.
"""

from functools import partial

from curves import few_lights
from curves import peers_refitted as peers
from curves.few_lights import FEW, ours, points_of
from curves.results import those_installed

TITLE = "Few lights, peers with refitted radiances"
READ = ": left is faster, down is more accurate"
ERRORS = {"probe": "error of a white probe", "shadows": "error of shadows"}
COUNTED, UNCOUNTED = "lights", ()
OURS = ("fit", "fit, points")
#: Numbers of lights of k-means and median cut, and of the slow generic optimisers.
MANY, SLOW = (1, 2, 4, 8, 16, 64), (1, 2, 4)

#: By name: numbers of lights, and the function that returns them.
METHODS = {
    "fit": (FEW, ours),
    "fit, points": (FEW, partial(ours, sizes=False)),
    "k-means + NNLS": (MANY, peers.k_means_refitted),
    "median cut + NNLS": (MANY, peers.median_cut_refitted),
    "discs, SciPy": (SLOW, peers.discs_by_scipy),
    "spherical Gaussians, SciPy": (SLOW, peers.gaussians_by_scipy),
    "points, SciPy": (FEW[:4], peers.points_by_scipy),
    "points, JAXopt": (FEW[:4], peers.points_by_jaxopt),
}
NEEDS = dict.fromkeys(("k-means + NNLS", "discs, SciPy", "spherical Gaussians, SciPy"), "sklearn")
METHODS = those_installed(METHODS, NEEDS | {"points, JAXopt": "jaxopt"})

are_comparable = few_lights.are_comparable


def points(maps, effort):
    """Yield a point for each map, method and number of lights."""
    return points_of("refitted", METHODS, maps, effort)
