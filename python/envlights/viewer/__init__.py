"""Pages that show things in a map, lit by a few lights, in real time.

| part                                        | file                       |
|---------------------------------------------|----------------------------|
| rigs, map and albedo as the page takes them | `data.py`                  |
| page of one file                            | `page.py`                  |
| light that ball and box hide, closed form   | `light.glsl`               |
| picture                                     | `scene.glsl`, `scene.js`   |
| controls                                    | `view.js`, `view.css`      |
"""
