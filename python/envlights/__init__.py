"""An environment map as a handful of lights.

>>> import envlights as el
>>> env = el.EnvMap(el.synthetic.hall(128).radiance)
>>> rig = el.fit(env, lights=4)
>>> len(rig.lights)
4
"""

import typing as _typing
from importlib import import_module as _import_module

from envlights import kernels
from envlights._common.errors import FileError
from envlights._common.notes import Note
from envlights._common.threads import threads
from envlights._native import EnvLightsError
from envlights.cards import Cards
from envlights.detection.detect import detect
from envlights.environment.envmap import EnvMap
from envlights.fitting.fit import fit, fit_probe
from envlights.rigs.lights import Lights
from envlights.rigs.rig import Rig
from envlights.splitting.limit import limit
from envlights.splitting.split import Split, split

__all__ = [
    "Cards",
    "EnvLightsError",
    "EnvMap",
    "FileError",
    "Lights",
    "Note",
    "Rig",
    "Split",
    "TransferModel",
    "bake",
    "batch",
    "compare",
    "compare_folders",
    "comparison",
    "detect",
    "detect_photograph",
    "error_curve",
    "export",
    "find_sun",
    "fit",
    "fit_probe",
    "follow",
    "io",
    "kernels",
    "limit",
    "papers",
    "place",
    "plot",
    "read_pairs",
    "rigs",
    "scene",
    "sequence",
    "split",
    "sun",
    "synthetic",
    "threads",
    "transfer",
    "vary",
    "view",
    "with_sun",
]

#: Packages that are imported when they are first used, so that `import envlights` is fast.
_PACKAGES = {
    "batches",
    "cli",
    "comparison",
    "export",
    "frames",
    "io",
    "layers",
    "papers",
    "placing",
    "plot",
    "scene",
    "sequence",
    "sun",
    "synthetic",
    "transfer",
    "viewer",
}
#: Functions and classes of `__all__` that are imported when they are first used, by their module.
_LATER = {
    "TransferModel": "transfer",
    "bake": "scene",
    "batch": "batches.batch",
    "compare": "comparison.compare",
    "compare_folders": "comparison.folders",
    "detect_photograph": "papers.photograph",
    "error_curve": "fitting.error_curve",
    "find_sun": "sun",
    "follow": "sequence",
    "place": "placing",
    "read_pairs": "transfer",
    "vary": "rigs.vary",
    "view": "viewer.page",
    "with_sun": "sun",
}

#: Former names in this module, by their package now; each warns, until the first release.
_FORMER = {
    "batches": "Batch LabelArrays label_arrays",
    "cards": "Card CardSplit",
    "comparison": "Comparison FolderComparison ImageErrors LightSetDifference Protocol"
    " compare_lights image_errors vector_angle",
    "detection": "DetectedLights DetectionReport",
    "fitting": "ErrorCurve",
    "io": "DamagedFileError MissingFileError",
    "papers": "PaperFit PhotographLight PhotographLights",
    "rigs": "FitReport StopReason rigs_to_frame",
    "scene": "BakedPairs Ball Box DirectLight MitsubaScene Polyhedron ShadowOverlay Surface"
    " shadow_overlay",
    "sequence": "FrameRig RigSequence RigStream",
    "splitting": "Limit RemovedLights",
    "sun": "Sun SunAt SunSplit",
    "transfer": "FilePairs TransferPrior TransferReport",
    "viewer": "Model View",
}
#: Former names of functions, and their names now.
_RENAMED = {
    "detect_article": "papers.loghin.detect",
    "detect_tree": "detect",
    "fit_paper": "papers.madsen.fit",
}

if _typing.TYPE_CHECKING:
    __version__: str
    from envlights import batches as batches
    from envlights import cards as cards
    from envlights import cli as cli
    from envlights import comparison as comparison
    from envlights import detection as detection
    from envlights import export as export
    from envlights import fitting as fitting
    from envlights import frames as frames
    from envlights import io as io
    from envlights import layers as layers
    from envlights import papers as papers
    from envlights import placing as placing
    from envlights import plot as plot
    from envlights import rigs as rigs
    from envlights import scene as scene
    from envlights import sequence as sequence
    from envlights import splitting as splitting
    from envlights import sun as sun
    from envlights import synthetic as synthetic
    from envlights import transfer as transfer
    from envlights import viewer as viewer
    from envlights.batches.batch import batch as batch
    from envlights.comparison.compare import compare as compare
    from envlights.comparison.folders import compare_folders as compare_folders
    from envlights.fitting.error_curve import error_curve as error_curve
    from envlights.papers.photograph import detect_photograph as detect_photograph
    from envlights.placing.place import place as place
    from envlights.rigs.vary import vary as vary
    from envlights.scene.bake import bake as bake
    from envlights.scene.floor_shadow import shadow_overlay as shadow_overlay
    from envlights.sequence.follow import follow as follow
    from envlights.sun import find_sun as find_sun
    from envlights.sun import with_sun as with_sun
    from envlights.transfer import TransferModel as TransferModel
    from envlights.transfer import read_pairs as read_pairs
    from envlights.viewer.page import view as view
else:

    def __getattr__(name):
        if name == "__version__":
            return _import_module("importlib.metadata").version(__name__)
        if name in _PACKAGES:
            return _import_module(f"{__name__}.{name}")
        if name in _LATER:
            return getattr(_import_module(f"{__name__}.{_LATER[name]}"), name)
        return _former(name)

    def _former(name):
        """Object of a former name, with a warning that has its name now."""
        from envlights._common.former import former

        packages = {each: package for package, names in _FORMER.items() for each in names.split()}
        if name not in _RENAMED and name not in packages:
            raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
        path = _RENAMED.get(name) or f"{packages[name]}.{name}"
        return former(f"el.{name}", f"el.{path}", _import_module(__name__), path, 3)


def __dir__() -> list[str]:
    return sorted({*__all__, "__version__"})
