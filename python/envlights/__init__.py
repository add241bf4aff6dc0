"""An environment map as a handful of lights.

>>> import envlights as el
>>> env = el.EnvMap(el.synthetic.hall(128).radiance)
>>> rig = el.fit(env, lights=4)
>>> len(rig.lights)
4
"""

from importlib.metadata import version as _version

from envlights import kernels, synthetic
from envlights._native import EnvLightsError
from envlights.article import detect_article
from envlights.detect import detect
from envlights.detected import DetectedLights, DetectionReport
from envlights.envmap import EnvMap
from envlights.fit import fit, fit_probe
from envlights.paper import PaperFit, fit_paper
from envlights.report import FitReport, StopReason
from envlights.rig import Lights, Rig
from envlights.scene import BakedPairs, DirectLight, MitsubaScene, Surface, bake
from envlights.transfer import FilePairs, TransferModel, TransferReport, read_pairs
from envlights.tree import detect_tree

__all__ = [
    "BakedPairs",
    "DetectedLights",
    "DetectionReport",
    "DirectLight",
    "EnvLightsError",
    "EnvMap",
    "FilePairs",
    "FitReport",
    "Lights",
    "MitsubaScene",
    "PaperFit",
    "Rig",
    "StopReason",
    "Surface",
    "TransferModel",
    "TransferReport",
    "bake",
    "detect",
    "detect_article",
    "detect_tree",
    "fit",
    "fit_paper",
    "fit_probe",
    "kernels",
    "read_pairs",
    "synthetic",
]

__version__ = _version("envlights")
