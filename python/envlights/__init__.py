"""An environment map as a handful of lights.

>>> import envlights as el
>>> env = el.EnvMap(el.synthetic.hall(128).radiance)
>>> rig = el.fit(env, lights=4)
>>> len(rig.lights)
4
"""

import typing as _typing
from importlib import import_module as _import_module

from envlights import _map_repair, _targets, kernels
from envlights._native import EnvLightsError
from envlights._notes import Note
from envlights._report_fields import StopReason
from envlights._threads import threads
from envlights.cards import Card, Cards, CardSplit
from envlights.detection.component_tree import detect_tree
from envlights.detection.detect import detect
from envlights.detection.lights import DetectedLights, DetectionReport
from envlights.detection.loghin import detect_article
from envlights.detection.photograph import detect_photograph
from envlights.detection.photograph_lights import PhotographLight, PhotographLights
from envlights.detection.removed_lights import RemovedLights
from envlights.detection.split import Split, split
from envlights.envmap import EnvMap
from envlights.excess import Limit, limit
from envlights.fitting.fit import fit, fit_probe
from envlights.io.errors import DamagedFileError, FileError, MissingFileError
from envlights.lights import Lights
from envlights.occluders import Ball, Box, Polyhedron
from envlights.report import FitReport
from envlights.rig import Rig, rigs_to_frame

__all__ = [
    "BakedPairs",
    "Ball",
    "Batch",
    "Box",
    "Card",
    "CardSplit",
    "Cards",
    "Comparison",
    "DamagedFileError",
    "DetectedLights",
    "DetectionReport",
    "DirectLight",
    "EnvLightsError",
    "EnvMap",
    "ErrorCurve",
    "FileError",
    "FilePairs",
    "FitReport",
    "FolderComparison",
    "FrameRig",
    "ImageErrors",
    "LabelArrays",
    "LightSetDifference",
    "Lights",
    "Limit",
    "MissingFileError",
    "MitsubaScene",
    "Model",
    "Note",
    "PaperFit",
    "PhotographLight",
    "PhotographLights",
    "Polyhedron",
    "Protocol",
    "RemovedLights",
    "Rig",
    "RigSequence",
    "RigStream",
    "ShadowOverlay",
    "Split",
    "StopReason",
    "Sun",
    "SunAt",
    "SunSplit",
    "Surface",
    "TransferModel",
    "TransferPrior",
    "TransferReport",
    "View",
    "bake",
    "batch",
    "compare",
    "compare_folders",
    "compare_lights",
    "detect",
    "detect_article",
    "detect_photograph",
    "detect_tree",
    "error_curve",
    "find_sun",
    "fit",
    "fit_paper",
    "fit_probe",
    "follow",
    "image_errors",
    "kernels",
    "label_arrays",
    "limit",
    "read_pairs",
    "rigs_to_frame",
    "shadow_overlay",
    "split",
    "synthetic",
    "threads",
    "vector_angle",
    "view",
    "with_sun",
]

#: Attributes, too. What a fit does not need is imported when it is first used, so that `import
#: envlights` does not wait for it; so is what reads the version.
_SUBPACKAGES = (
    *("cli", "comparison", "detection", "export", "fitting", "io", "plot", "scene"),
    *("sequence", "sun", "synthetic", "transfer"),
)
#: Names of `__all__` that come from one of them.
_LATER = {
    **dict.fromkeys(("ErrorCurve", "error_curve"), "fitting.error_curve"),
    **dict.fromkeys(("PaperFit", "fit_paper"), "fitting.madsen"),
    **dict.fromkeys(("BakedPairs", "DirectLight", "MitsubaScene", "Surface", "bake"), "scene"),
    **dict.fromkeys(("ShadowOverlay", "shadow_overlay"), "scene"),
    **dict.fromkeys(("FrameRig", "RigSequence", "RigStream", "follow"), "sequence"),
    **dict.fromkeys(("View", "view"), "viewer.page"),
    **dict.fromkeys(("Comparison", "compare"), "comparison.compare"),
    **dict.fromkeys(("FolderComparison", "compare_folders"), "comparison.folders"),
    **dict.fromkeys(("ImageErrors", "image_errors"), "comparison.image_errors"),
    "LightSetDifference": "comparison.light_set_difference",
    "Protocol": "comparison.protocol",
    "compare_lights": "comparison.light_sets",
    "vector_angle": "comparison.vector_angle",
    "Model": "viewer.model",
    "Batch": "many.result",
    "batch": "many.batch",
    **dict.fromkeys(("LabelArrays", "label_arrays"), "many.labels"),
    **dict.fromkeys(("Sun", "SunAt", "SunSplit", "find_sun", "with_sun"), "sun"),
    **dict.fromkeys(
        ("FilePairs", "TransferModel", "TransferPrior", "TransferReport", "read_pairs"), "transfer"
    ),
}

# The first `save` loads the exporters, which register themselves.
_targets.register_later(lambda: _import_module(f"{__name__}.export"))
# So does the first repair with a sun.
_map_repair.register_later(lambda: _import_module(f"{__name__}.sun").repair_with_sun)

if _typing.TYPE_CHECKING:
    __version__: str
    from envlights import cli as cli
    from envlights import comparison as comparison
    from envlights import detection as detection
    from envlights import export as export
    from envlights import fitting as fitting
    from envlights import io as io
    from envlights import plot as plot
    from envlights import scene as scene
    from envlights import sequence as sequence
    from envlights import sun as sun
    from envlights import synthetic as synthetic
    from envlights import transfer as transfer
    from envlights.comparison.compare import Comparison, compare
    from envlights.comparison.folders import FolderComparison, compare_folders
    from envlights.comparison.image_errors import ImageErrors, image_errors
    from envlights.comparison.light_set_difference import LightSetDifference
    from envlights.comparison.light_sets import compare_lights
    from envlights.comparison.protocol import Protocol
    from envlights.comparison.vector_angle import vector_angle as vector_angle
    from envlights.fitting.error_curve import ErrorCurve, error_curve
    from envlights.fitting.madsen import PaperFit, fit_paper
    from envlights.many.batch import batch as batch
    from envlights.many.labels import LabelArrays, label_arrays
    from envlights.many.result import Batch
    from envlights.scene import BakedPairs, DirectLight, MitsubaScene, ShadowOverlay, Surface
    from envlights.scene.bake import bake as bake
    from envlights.scene.floor_shadow import shadow_overlay as shadow_overlay
    from envlights.sequence import FrameRig, RigSequence, RigStream
    from envlights.sequence.follow import follow as follow
    from envlights.sun import Sun, SunAt, SunSplit, find_sun, with_sun
    from envlights.transfer import (
        FilePairs,
        TransferModel,
        TransferPrior,
        TransferReport,
        read_pairs,
    )
    from envlights.viewer.model import Model
    from envlights.viewer.page import View, view
else:

    def __getattr__(name):
        if name == "__version__":
            return _import_module("importlib.metadata").version(__name__)
        if name in _SUBPACKAGES:
            return _import_module(f"{__name__}.{name}")
        if name in _LATER:
            return getattr(_import_module(f"{__name__}.{_LATER[name]}"), name)
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")


def __dir__() -> list[str]:
    return sorted({*__all__, *_SUBPACKAGES, "__version__"})
