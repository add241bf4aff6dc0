"""Run notebooks and store them with small outputs: `python notebooks/store_outputs.py [NAME ...]`.

Needs the extra `test`. A picture of at most 60 kB suffices to read a notebook on the web.
"""

import base64
import io
import os
import re
import sys
from pathlib import Path

import nbclient
import nbformat
from PIL import Image

FOLDER = Path(__file__).parent
#: Largest picture, in bytes before base64.
LARGEST = 60_000
#: Kind of a progress bar.
WIDGET = "application/vnd.jupyter.widget-view+json"


def small_png(data: bytes) -> bytes:
    """Reduce a picture to 128 colours, and to as few pixels as its size demands."""
    picture = Image.open(io.BytesIO(data)).convert("RGB")
    while True:
        file = io.BytesIO()
        picture.quantize(128, dither=Image.Dither.FLOYDSTEINBERG).save(file, "png", optimize=True)
        if len(file.getvalue()) <= LARGEST:
            return file.getvalue()
        width, height = picture.size
        picture = picture.resize((9 * width // 10, 9 * height // 10), Image.Resampling.LANCZOS)


def small_code(code: str) -> str:
    """A picture in base64, made small if it is not."""
    data = base64.b64decode(code)
    return base64.b64encode(small_png(data)).decode() if len(data) > LARGEST else code.strip()


def small_output(output: nbformat.NotebookNode) -> nbformat.NotebookNode:
    """An output without bookkeeping, its pictures small."""
    data = output.get("data", {})
    if "image/png" in data:
        data["image/png"] = small_code(data["image/png"])
    if "text/html" in data:
        data["text/html"] = re.sub(
            r"(?<=data:image/png;base64,)[\w+/=]+",
            lambda found: small_code(found.group()),
            data["text/html"],
        )
    return output


def without_bars(outputs: list[nbformat.NotebookNode]) -> list[nbformat.NotebookNode]:
    """Outputs without progress bars, adjacent pieces of text as one."""
    kept: list[nbformat.NotebookNode] = []
    for output in outputs:
        if output.get("name") == "stderr" or WIDGET in output.get("data", {}):
            continue
        if kept and output.output_type == kept[-1].output_type == "stream":
            kept[-1].text += output.text
        else:
            kept.append(output)
    return kept


def store(path: Path) -> None:
    """Run a notebook and write it with its outputs."""
    notebook = nbformat.read(path, as_version=4)
    nbclient.NotebookClient(notebook, timeout=600, record_timing=False).execute()
    for cell in notebook.cells:
        cell.metadata.clear()
        if cell.cell_type == "code":
            cell.outputs = [small_output(each) for each in without_bars(cell.outputs)]
    notebook.metadata.pop("widgets", None)
    notebook.metadata.language_info = {"name": "python"}
    nbformat.write(notebook, path)
    print(f"{path.name}: {path.stat().st_size / 1000:.0f} kB")


def main() -> None:
    """Store all notebooks, or those that are named."""
    os.environ.pop("ENVLIGHTS_MAP", None)
    names = sys.argv[1:] or [path.stem for path in sorted(FOLDER.glob("*.ipynb"))]
    for name in names:
        store(FOLDER / f"{name}.ipynb")


if __name__ == "__main__":
    main()
