"""Equations of Madsen, Sørensen and Vittrup (2003), for any least-squares solver."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _native
from envlights._common.check import amount, colour, count, flag, float_image, reals

_WHITE = (1.0, 1.0, 1.0)


def face_radiance(
    radiance: ArrayLike, faces: int = 5120, *, border_sampled: bool = False
) -> NDArray[np.float64]:
    """Mean radiance of an equirectangular map in each face of an icosphere: the paper's scene.

    Faces and pixels hold the same flux. With `icosphere` these are the K sources of equations 1
    to 3, which `sum_over_sources` adds up.

    Parameters
    ----------
    radiance : array_like, shape (height, width, 3)
        Linear RGB, converted to float32.
    faces : int
        ``20 * 4**k``; 5120 in the paper.
    border_sampled : bool
        True: the outer pixels lie on the seam and the poles.

    Returns
    -------
    ndarray, shape (faces, 3)
        In the order of ``icosphere(faces)``. A face that no pixel's sample lies in is black: a
        map should have more pixels than there are faces.

    Examples
    --------
    >>> face_radiance(np.ones((512, 1024, 3)), faces=20).round(2)[0]
    array([1., 1., 1.])
    """
    image = float_image("radiance", radiance, 3)
    return _native.face_radiance(
        image, count("faces", faces), flag("border_sampled", border_sampled)
    )


def pack_lights(
    ambient: ArrayLike, directions: ArrayLike, irradiance: ArrayLike
) -> NDArray[np.float64]:
    """Pack ambient light and M lights into a vector of unknowns.

    Parameters
    ----------
    ambient : array_like, shape (3,)
        Radiance of the ambient light.
    directions : array_like, shape (M, 3)
        Unit vectors towards the lights.
    irradiance : array_like, shape (M, 3)
        Irradiance of each light at normal incidence: radiance times solid angle.

    Returns
    -------
    ndarray, shape (3 + 5 * M,)
        Ambient RGB, then for each light RGB, theta (0 at +y) and phi (from -z over +x).

    See Also
    --------
    unpack_lights : the inverse.

    Notes
    -----
    These are the paper's polar angles, with its axes (x, y, z) called (-z, x, y) here.

    Examples
    --------
    >>> pack_lights([0.1, 0.2, 0.3], [[1, 0, 0]], [[4, 5, 6]]).round(3)
    array([0.1  , 0.2  , 0.3  , 4.   , 5.   , 6.   , 1.571, 1.571])
    """
    lights = reals("directions", directions, 2), reals("irradiance", irradiance, 2)
    return _native.pack_lights(reals("ambient", ambient, 1), *lights)


def unpack_lights(
    x: ArrayLike,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Unpack ambient light and M lights from a vector of unknowns.

    Parameters
    ----------
    x : array_like, shape (3 + 5 * M,)
        Unknowns from `pack_lights`; theta and phi may be any angles.

    Returns
    -------
    ambient : ndarray, shape (3,)
    directions : ndarray, shape (M, 3)
        Unit vectors.
    irradiance : ndarray, shape (M, 3)

    Examples
    --------
    >>> ambient, directions, irradiance = unpack_lights([0, 0, 0, 4, 5, 6, 2 * np.pi, 1])
    >>> directions.round(12) + 0.0, irradiance
    (array([[0., 1., 0.]]), array([[4., 5., 6.]]))
    """
    return _native.unpack_lights(reals("x", x, 1))


def probe_model(
    x: ArrayLike,
    normals: ArrayLike,
    *,
    k_a: float = np.pi,
    k_d: float = 1.0,
    C: Sequence[float] = _WHITE,  # noqa: N803, the paper's name
) -> NDArray[np.float64]:
    r"""Radiance of the probe under ambient light and M lights: equations 4 to 6.

    Parameters
    ----------
    x : array_like, shape (3 + 5 * M,)
        The unknowns; see `pack_lights`.
    normals : array_like, shape (n, 3)
        Unit vectors.
    k_a : float
        Coefficient of ambient reflection. With pi, and `k_d` and `C` of 1, the probe's values are
        irradiances, ambient light is the radiance of a constant environment, and `rig_irradiance`
        gives the same; 0 leaves ambient light out.
    k_d : float
        Coefficient of diffuse reflection.
    C : sequence of 3 floats
        Colour of the probe.

    Returns
    -------
    ndarray, shape (n, 3)
        :math:`k_a C L_a + \sum_j k_d C L_j \max(0, n \cdot l_j)`.

    Examples
    --------
    >>> x = pack_lights([0.1, 0.1, 0.1], [[0, 1, 0]], [[1, 2, 3]])
    >>> probe_model(x, [[0, 1, 0], [0, -1, 0]], k_a=1)
    array([[1.1, 2.1, 3.1],
           [0.1, 0.1, 0.1]])
    """
    surface = _surface(k_a, k_d, C)
    return _native.probe_model(reals("x", x, 1), reals("normals", normals, 2), surface)


def probe_residual(
    x: ArrayLike,
    normals: ArrayLike,
    probe: ArrayLike,
    *,
    weights: ArrayLike | None = None,
    k_a: float = np.pi,
    k_d: float = 1.0,
    C: Sequence[float] = _WHITE,  # noqa: N803, the paper's name
) -> NDArray[np.float64]:
    r"""Residual of a probe under M lights: the left sides of equations 7 to 9.

    The arguments suit `scipy.optimize.least_squares` and `jaxopt.LevenbergMarquardt`, for other
    solvers than that of `fit`.

    Parameters
    ----------
    x : array_like, shape (3 + 5 * M,)
        The unknowns; see `pack_lights`.
    normals : array_like, shape (n, 3)
        Unit vectors.
    probe : array_like, shape (n, 3)
        Measured values: irradiance, for the default coefficients.
    weights : array_like, shape (n,), optional
        Weight of each normal, such as its solid angle. Default: equal weights, as in the paper.
    k_a, k_d, C
        Coefficients; see `probe_model`.

    Returns
    -------
    ndarray, shape (3 * n,)
        :math:`\sqrt{w} (R - k_a C L_a - \sum_j k_d C L_j \max(0, n \cdot l_j))`: R, G and B of the
        first normal, then of the next.

    See Also
    --------
    probe_jacobian : its derivatives.
    envlights.papers.madsen.fit : all of the paper's steps from a map to lights.

    Examples
    --------
    With SciPy, here to bounds that keep radiances from going negative:

    >>> from envlights.kernels import icosphere, rig_irradiance
    >>> from scipy.optimize import least_squares
    >>> normals, weights = icosphere(320)
    >>> probe = rig_irradiance(normals, [0.1, 0.1, 0.1], [[0, 0.6, 0.8]], [[3, 2, 1]])
    >>> start = pack_lights([1, 1, 1], [[0, 0, 1]], [[1, 1, 1]])
    >>> low = [0] * 6 + [-np.inf] * 2
    >>> best = least_squares(
    ...     probe_residual,
    ...     start,
    ...     probe_jacobian,
    ...     bounds=(low, np.inf),
    ...     args=(normals, probe),
    ...     kwargs={"weights": weights, "k_a": np.pi},
    ... )
    >>> ambient, directions, irradiance = unpack_lights(best.x)
    >>> ambient.round(6), directions.round(6), irradiance.round(6)
    (array([0.1, 0.1, 0.1]), array([[0. , 0.6, 0.8]]), array([[3., 2., 1.]]))
    """
    measured = _measure(normals, probe, weights)
    return _native.probe_residual(reals("x", x, 1), *measured, _surface(k_a, k_d, C))


def probe_jacobian(
    x: ArrayLike,
    normals: ArrayLike,
    probe: ArrayLike,
    *,
    weights: ArrayLike | None = None,
    k_a: float = np.pi,
    k_d: float = 1.0,
    C: Sequence[float] = _WHITE,  # noqa: N803, the paper's name
) -> NDArray[np.float64]:
    """Derivatives of `probe_residual` by each unknown.

    Exact everywhere but on the terminator of a light, where the model has a kink: a normal there
    gets the derivative of its dark side, 0.

    Parameters
    ----------
    x, normals, probe, weights, k_a, k_d, C
        As for `probe_residual`. The values of `probe` do not matter, since the residual is linear
        in them; solvers give both functions the same arguments.

    Returns
    -------
    ndarray, shape (3 * n, 3 + 5 * M)
        Where a light is at theta = 0 or pi, its column of phi is 0: solvers that factor the
        Jacobian must handle the missing rank there.

    Examples
    --------
    >>> x = pack_lights([0, 0, 0], [[0, 1, 0]], [[1, 2, 3]])
    >>> probe_jacobian(x, [[0, 1, 0]], [[0, 0, 0]], k_a=1)[0] + 0.0
    array([-1.,  0.,  0., -1.,  0.,  0.,  0.,  0.])
    """
    measured = _measure(normals, probe, weights)
    return _native.probe_jacobian(reals("x", x, 1), *measured, _surface(k_a, k_d, C))


def _measure(
    normals: ArrayLike, probe: ArrayLike, weights: ArrayLike | None
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    normals, probe = reals("normals", normals, 2), reals("probe", probe, 2)
    weights = np.ones(len(normals)) if weights is None else reals("weights", weights, 1)
    return normals, probe, weights


def _surface(
    k_a: object,
    k_d: object,
    C: ArrayLike,  # noqa: N803, the paper's name
) -> tuple[float, float, list[float]]:
    """Check the reflectance parameters of the probe."""
    return amount("k_a", k_a), amount("k_d", k_d), colour("C", C)
