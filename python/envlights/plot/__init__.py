"""Pictures: a map with its lights, the probe or a scene under either, and indirect light."""

from envlights.plot.figure import Picture, save
from envlights.plot.maps import detection_picture, picture
from envlights.plot.scene import scene
from envlights.plot.transfer import transfer_picture

__all__ = ["Picture", "detection_picture", "picture", "save", "scene", "transfer_picture"]


def __dir__() -> list[str]:
    return sorted(__all__)
