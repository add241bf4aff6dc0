"""Mitsuba 3: emitters as a dictionary for `load_dict`, or as an XML file.

Mitsuba has our axes and units. Three things differ. The direction of a directional light is the one
in which light travels. A scene has one environment, so lights with a size are drawn into the map of
the ambient term. The first and the last row of that map lie on the poles.
"""

from __future__ import annotations

import importlib
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from envlights import kernels
from envlights._native import EnvLightsError
from envlights.environment.envmap import EnvMap
from envlights.environment.reading import AnyMap
from envlights.export.discs import MOST_ROWS, rows_for, split_by_size
from envlights.export.files import AnyPath, check_link
from envlights.export.formats import mitsuba_cards
from envlights.export.formats.xml_text import comment, document
from envlights.export.panels import crop_names
from envlights.export.scene import Discs, Exportable, Scene, scene_of
from envlights.export.textures import Beside, save_beside

#: A dollar sign begins the name of a parameter; XML forbids the others.
_REFUSED = ("$", "\ufffe", "\uffff", *(chr(c) for c in range(32) if chr(c) not in "\t\n\r"))

#: Normals among which the one with most light is searched.
_NORMALS = kernels.pixel_directions(8, 16).reshape(-1, 3)
#: Least weight of an emitter. It costs others 1 % of their paths at most, and emitters that are
#: brightened after loading still light the scene.
_LEAST_WEIGHT = 0.01


def mitsuba(rig: Exportable, environment: AnyMap | None = None) -> dict[str, Any]:
    r"""The emitters of a rig, to be merged into the dictionary of a scene.

    Parameters
    ----------
    rig : Rig, Lights or Cards
    environment : EnvMap or array_like, optional
        Map that replaces the ambient term.

    Returns
    -------
    dict
        ``light_0`` and so on: points as "directional", with the same irradiance values as
        envlights, in W m\ :sup:`-2`. ``ambient``: "constant" with our radiance, or an "envmap" that
        also holds the lights with a size. Harmonics are cut off where they are negative; over a
        floor the lower half is black.

    Notes
    -----
    After `EnvMap.calibrated` the numbers are lux and cd/m2, and so are the pixels of an image.

    Mitsuba picks one emitter at random at each surface. `sampling_weight` makes an emitter more
    probable in proportion to the irradiance of the surface that it lights most; the mean is 1, the
    weight of other emitters. For four points and their surroundings, the noise is 0.27 to 0.75
    times that of equal weights (128 paths per pixel, three maps). Rendering each emitter alone,
    with paths in the same proportion, and adding the images lowers it again, by a factor of 0.52
    to 0.95.

    ``"hide_emitters": True`` in the integrator hides the surroundings from the camera.

    Examples
    --------
    >>> import envlights as el
    >>> emitters = el.export.mitsuba(el.Lights([[0, 1, 0]], [[3, 2, 1]]))
    >>> emitters["light_0"]["direction"], emitters["light_0"]["irradiance"]["value"]
    ([0.0, -1.0, 0.0], [3.0, 2.0, 1.0])
    """
    scene = scene_of(rig, environment, target="mitsuba")
    emitters = {**directional(scene.lights), **mitsuba_cards.shapes(scene.panels)}
    radiance = _map_of(scene)
    if radiance is not None:
        emitters["ambient"] = envmap(radiance)
    elif scene.ambient is not None:
        emitters["ambient"] = constant(scene.ambient)
    cards = {panel.name: panel.irradiance.tolist() for panel in scene.panels}
    return add_weights(emitters, largest_irradiance(radiance, scene.ambient), cards)


def save_mitsuba(rig: Exportable, path: AnyPath, environment: AnyMap | None = None) -> None:
    """Write `mitsuba` as XML: a scene of emitters, to be loaded or included in another scene.

    A map goes beside it, ``scene.ambient.mitsuba.exr``, with its rows as Mitsuba reads them.
    """
    scene = scene_of(rig, environment, target="mitsuba")
    radiance = _map_of(scene)
    save_beside(
        path,
        scene,
        "mitsuba",
        lambda scene, names: _xml(scene, radiance, names),
        map_of=lambda _: radiance,
        crop_of=mitsuba_cards.texture_of,
    )


def _xml(scene: Scene, radiance: NDArray[np.float64] | None, names: Beside) -> str:
    """Scene of emitters as XML."""
    root = ElementTree.Element("scene", version="3.0.0")
    root.append(comment(f" {scene.statement} "))
    lights = directional(scene.lights)
    for name, light in lights.items():
        emitter = ElementTree.SubElement(root, "emitter", type="directional", id=name)
        x, y, z = map(repr, light["direction"])
        ElementTree.SubElement(emitter, "vector", name="direction", x=x, y=y, z=z)
        _rgb_element(emitter, "irradiance", light["irradiance"]["value"])
    crops = crop_names(scene.panels, names.prefix, "mitsuba")
    for name in crops:
        check_link(name, "Mitsuba", _REFUSED)
    mitsuba_cards.add_shapes(root, scene.panels, crops)
    if radiance is not None:
        check_link(names.map, "Mitsuba", _REFUSED)
        emitter = ElementTree.SubElement(root, "emitter", type="envmap", id="ambient")
        ElementTree.SubElement(emitter, "string", name="filename", value=names.map)
    elif scene.ambient is not None:
        emitter = ElementTree.SubElement(root, "emitter", type="constant", id="ambient")
        _rgb_element(emitter, "radiance", scene.ambient.tolist())
    cards = [panel.irradiance.tolist() for panel in scene.panels]
    weights = sampling_weights(lights, largest_irradiance(radiance, scene.ambient), cards)
    for emitter, weight in zip(root.iter("emitter"), weights, strict=True):
        ElementTree.SubElement(emitter, "float", name="sampling_weight", value=repr(weight))
    return document(root)


def directional(lights: Discs) -> dict[str, dict[str, Any]]:
    """The points among `lights` as emitters, with the direction in which light travels."""
    points = np.flatnonzero(lights.angular_radius == 0)
    return {
        f"light_{place}": {
            "type": "directional",
            "direction": (0.0 - lights.direction[j]).tolist(),
            "irradiance": _rgb(lights.irradiance[j]),
        }
        for place, j in enumerate(points)
    }


def constant(radiance: NDArray[np.float64]) -> dict[str, Any]:
    """An emitter of one radiance from everywhere."""
    return {"type": "constant", "radiance": _rgb(radiance)}


def envmap(radiance: NDArray[Any]) -> dict[str, Any]:
    """An emitter of a map whose first and last row lie on the poles."""
    try:
        # Import it only when needed: it is in the extra `bake`.
        bitmap = importlib.import_module("mitsuba").Bitmap
    except ImportError as error:
        raise EnvLightsError(
            f"Mitsuba cannot be imported: {error}; install it with pip install 'envlights[bake]',"
            " or save an .xml, which needs no Mitsuba"
        ) from None
    return {"type": "envmap", "bitmap": bitmap(radiance.astype(np.float32))}


def add_weights(
    emitters: dict[str, dict[str, Any]],
    surroundings: NDArray[np.float64] | None,
    cards: dict[str, list[float]] | None = None,
) -> dict[str, dict[str, Any]]:
    """Emitters of `directional`, cards, and surroundings after them, with `sampling_weight`.

    `cards` are the irradiances of the cards among the emitters.
    """
    lights = {name: each for name, each in emitters.items() if "irradiance" in each}
    weights = sampling_weights(lights, surroundings, list((cards or {}).values()))
    return {
        name: _with_weight(emitter, weight)
        for (name, emitter), weight in zip(emitters.items(), weights, strict=True)
    }


def _with_weight(emitter: dict[str, Any], weight: float) -> dict[str, Any]:
    """Emitter, or shape with an emitter, with its weight."""
    if "emitter" not in emitter:
        return {**emitter, "sampling_weight": weight}
    return {**emitter, "emitter": {**emitter["emitter"], "sampling_weight": weight}}


def sampling_weights(
    lights: dict[str, dict[str, Any]],
    surroundings: NDArray[np.float64] | None,
    cards: list[list[float]] | None = None,
) -> list[float]:
    """Weights in proportion to irradiance: of lights, cards and surroundings; their mean is 1."""
    irradiances = [light["irradiance"]["value"] for light in lights.values()]
    irradiances += cards or []
    if surroundings is not None:
        irradiances.append(surroundings.tolist())
    sizes = np.linalg.norm(np.reshape(irradiances, (-1, 3)), axis=1)
    if not sizes.any():
        return [1.0] * len(sizes)
    weights: list[float] = np.maximum(sizes / sizes.mean(), _LEAST_WEIGHT).tolist()
    return weights


def largest_irradiance(
    radiance: NDArray[Any] | None, ambient: NDArray[np.float64] | None
) -> NDArray[np.float64] | None:
    """Irradiance of the surface that gets most from a map with rows on the poles, or a constant."""
    if radiance is None:
        return None if ambient is None else np.pi * ambient
    # Half a row too high: that changes no weight.
    cells = np.ascontiguousarray(radiance[:-1], np.float32)
    irradiance = kernels.irradiance(cells, _NORMALS)
    largest: NDArray[np.float64] = irradiance[np.linalg.norm(irradiance, axis=1).argmax()]
    return largest


def discs_on_poles(lights: Discs, least_rows: int = 0) -> NDArray[np.float64] | None:
    """A map of the lights with a size, rows on the poles, (rows + 1, 2 * rows, 3), or None.

    A map is the most accurate form of a disc at infinity in Mitsuba. A far sphere as an area
    light has the same noise, but it was off by 0.4 % at a radius of 0.27 degrees and by 50 %
    at 89.5 degrees, and it hides the lights behind it.
    """
    _, discs = split_by_size(lights, np.nextafter(0, 1))
    if not len(discs):
        return None
    return rows_on_poles(discs.to_map(least_rows or rows_for(discs)).radiance)


def rows_on_poles(radiance: NDArray[Any]) -> NDArray[np.float64]:
    """Resample a cell-centred map so that rows lie on cell edges, the first and last on the poles.

    Without this change, a light would move by half a row at the poles.
    """
    edges = np.concatenate([radiance[:1], radiance, radiance[-1:]]).astype(np.float64)
    halves: NDArray[np.float64] = (edges[1:] + edges[:-1]) / 2
    return halves


def sharp_rows_on_poles(env: EnvMap) -> NDArray[np.float64]:
    """Rows of cells so fine that Mitsuba's interpolation hardly blurs the map."""
    times = -(-MOST_ROWS // env.height)
    return rows_on_poles(env.cells().repeat(times, axis=0).repeat(times, axis=1))


def _map_of(scene: Scene) -> NDArray[np.float64] | None:
    """Map of a scene: its discs added to its environment; None if it needs no map."""
    if scene.environment is None:
        discs = discs_on_poles(scene.lights)
        if discs is None or scene.ambient is None:
            return discs
        return discs + scene.ambient
    if not scene.has_map and not scene.lights.angular_radius.any():
        return rows_on_poles(scene.environment.cells())
    around = sharp_rows_on_poles(scene.environment)
    discs = discs_on_poles(scene.lights, len(around) - 1)
    return around if discs is None else around + discs


def _rgb(values: NDArray[np.float64]) -> dict[str, Any]:
    return {"type": "rgb", "value": values.tolist()}


def _rgb_element(parent: ElementTree.Element, name: str, values: list[float]) -> None:
    ElementTree.SubElement(parent, "rgb", name=name, value=" ".join(map(repr, values)))
