"""Pictures: a map with its lights, the probe under either, and indirect light beside the truth."""

from envlights.plot.figure import Picture, save
from envlights.plot.maps import detection_picture, picture
from envlights.plot.transfer import transfer_picture

__all__ = ["Picture", "detection_picture", "picture", "save", "transfer_picture"]
