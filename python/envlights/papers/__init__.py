"""Published methods, composed of the steps in `kernels`.

| paper                                                        | file                            |
|--------------------------------------------------------------|---------------------------------|
| Loghin (2021): detection in a map                            | `loghin.py`                     |
| - its settings and steps, for maps and photographs           | `loghin_steps.py`               |
| - detection in a photograph                                  | `photograph.py`                 |
| - the file or array of a photograph                          | `photograph_pixels.py`          |
| - lights of a photograph, and their files                    | `photograph_lights.py`          |
| Madsen, Sørensen and Vittrup (2003): the fit                 | `madsen.py`                     |
"""

from envlights.papers import loghin, madsen
from envlights.papers.madsen import PaperFit
from envlights.papers.photograph_lights import PhotographLight, PhotographLights

__all__ = [
    "PaperFit",
    "PhotographLight",
    "PhotographLights",
    "loghin",
    "madsen",
]
