"""Pictures: a map with its lights, the probe under either, and indirect light beside the truth."""

from envlights.plot.maps import Picture, detection_picture, display, picture, save
from envlights.plot.transfer import transfer_picture

__all__ = ["Picture", "detection_picture", "display", "picture", "save", "transfer_picture"]
