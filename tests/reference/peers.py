"""Other people's solvers on the equations of Madsen et al. (2003), each from a given start.

| solver    | what it is                                                     | radiances       |
|-----------|----------------------------------------------------------------|-----------------|
| `bounded` | scipy's trust region, reflective (Branch, Coleman and Li 1999) | not negative    |
| `trf`     | the same without bounds                                        | may be negative |
| `lm`      | MINPACK's Levenberg-Marquardt, through scipy                   | may be negative |
| `jaxopt`  | jaxopt's Levenberg-Marquardt with JAX's own derivatives        | may be negative |
"""

from contextlib import contextmanager
from functools import cache, partial

import numpy as np
from scipy.optimize import least_squares

import envlights as el
from envlights import kernels
from tests.reference import madsen

#: Far below what is compared, so that no peer stops early.
TIGHT = 1e-12


class Problem(madsen.Problem):
    """The fit of some lights to a probe; the ambient term is an unknown, or fixed at zero."""

    def __init__(self, normals, weights, irradiance, lights, ambient="constant"):
        super().__init__(normals, weights, irradiance, lights)
        self.weights, self.ambient = weights, ambient
        self.fixed = {"constant": 0, "none": 3}[ambient]

    def with_lights(self, lights):
        return Problem(self.normals, self.weights, self.irradiance, lights, self.ambient)

    def whole(self, x):
        """`x` with the ambient radiance, where that is fixed at zero."""
        return np.concatenate([np.zeros(self.fixed), x])

    def residual(self, x):
        return super().residual(self.whole(x))

    def jacobian(self, x):
        return super().jacobian(self.whole(x))[:, self.fixed :]

    def bounds(self):
        low = np.concatenate([np.zeros(3), np.tile([0, 0, 0, -np.inf, -np.inf], self.lights)])
        return low[self.fixed :], np.inf

    def fraction(self, x):
        """The cost of `x`: the sum of squared residuals over that of the probe."""
        whole = np.sum((self.root * self.irradiance) ** 2)
        return float(np.sum(self.residual(x) ** 2) / whole)

    def is_possible(self, x):
        """True if no radiance is negative, up to rounding."""
        low, _ = self.bounds()
        return bool((x >= low - 1e-9 * np.abs(x).max()).all())

    def unknowns(self, rig):
        """The unknowns of a rig that was fitted."""
        lights = rig.lights
        return kernels.pack_lights(rig.ambient, lights.direction, lights.irradiance)[self.fixed :]

    def random_start(self, rng):
        return super().random_start(rng)[self.fixed :]


def by_scipy(problem, start, method="trf", has_bounds=False, tolerance=TIGHT):
    bounds = {"bounds": problem.bounds()} if has_bounds else {}
    stop = dict.fromkeys(("ftol", "xtol", "gtol"), tolerance)
    function, jacobian = problem.residual, problem.jacobian
    return least_squares(function, start, jacobian, method=method, **stop, **bounds).x


def by_jaxopt(problem, start, tolerance=TIGHT, has_bounds=False):
    """The answer of jaxopt; its solver has no bounds, so those are squares of its unknowns."""
    if not has_bounds:
        with jax_in_float64():
            return np.asarray(compiled_jaxopt(problem, start, tolerance)())
    bounded = np.isfinite(problem.bounds()[0])
    root = np.where(bounded, np.sqrt(np.maximum(start, 0)), start)
    with jax_in_float64():
        x = np.asarray(compiled_jaxopt(problem, root, tolerance, tuple(bounded))())
    return np.where(bounded, x**2, x)


def compiled_jaxopt(problem, start, tolerance, squares=None):
    """Return the solver with its arguments; it compiles when it is first called."""
    import jax

    solve = _compile_solver(problem.fixed, tolerance, squares)
    given = jax.device_put((start, problem.normals, problem.root, problem.irradiance))
    return lambda: solve(*given).block_until_ready()


@contextmanager
def jax_in_float64():
    """JAX with 64-bit numbers inside this context, and as it was outside."""
    import jax

    before = jax.config.jax_enable_x64
    jax.config.update("jax_enable_x64", True)
    try:
        yield jax
    finally:
        jax.config.update("jax_enable_x64", before)


@cache
def _compile_solver(fixed, tolerance, squares):
    """The whole solver as one compiled function; `squares` names unknowns that are squared."""
    import jax
    import jax.numpy as jnp
    import jaxopt

    def residual(x, normals, root, irradiance):
        x = x if squares is None else jnp.where(jnp.array(squares), x**2, x)
        x = jnp.concatenate([jnp.zeros(fixed), x])
        cosine = jnp.maximum(madsen.cosines(x, normals, jnp), 0)
        model = jnp.pi * x[:3] + cosine @ x[3:].reshape(-1, 5)[:, :3]
        return (root * (model - irradiance)).ravel()

    solver = jaxopt.LevenbergMarquardt(
        residual, materialize_jac=True, solver="cholesky", tol=tolerance, maxiter=200
    )
    return jax.jit(lambda start, *given: solver.run(start, *given).params)


PEERS = {
    "bounded": partial(by_scipy, has_bounds=True),
    "trf": by_scipy,
    "lm": partial(by_scipy, method="lm"),
    "jaxopt": by_jaxopt,
}


def even(lights):
    """The paper's start: directions spread evenly, none of them a pole."""
    return kernels.uniform_sphere(kernels.hammersley(lights) + np.array([0.5 / lights, 0]))


def ours(problem, **options):
    """Our own answer."""
    given = problem.normals, problem.irradiance, problem.lights
    return el.fit_probe(*given, weights=problem.weights, ambient=problem.ambient, **options)


def ours_from(problem, directions):
    """Our own answer near lights in these directions."""
    lights = el.Lights(directions, np.ones((len(directions), 3)))
    return ours(problem, start=el.Rig(np.zeros(3), lights, 0.0))
