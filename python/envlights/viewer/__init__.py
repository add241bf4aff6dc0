"""Pages that show things in a map, lit by a few lights, in real time.

| part                                        | file                       |
|---------------------------------------------|----------------------------|
| rigs, map and albedo as the page takes them | `data.py`                  |
| page of one file                            | `page.py`                  |
| light that ball and box hide, closed form   | `light.glsl`               |
| picture                                     | `scene.glsl`, `scene.js`   |
| controls                                    | `view.js`, `view.css`      |
| lights: rows, handles, files                | `lights.js`                |
| models of the user's                        | `model.py`                 |
| - in files                                  | `model_file.py`            |
| - as textures                               | `model_textures.py`, `model.js` |
| - rays against them                         | `model.glsl`               |
| - light between them and their surroundings | `paths.glsl`               |
| widget of Jupyter                           | `widget.py`, `widget.js`   |
"""

from envlights.viewer.model import Model
from envlights.viewer.page import View

__all__ = [
    "Model",
    "View",
]
