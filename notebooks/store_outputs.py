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


def small_picture(data: bytes) -> tuple[str, bytes]:
    """Type and file of a picture: a PNG as it is, or a JPEG of the best quality that fits."""
    if len(data) <= LARGEST:
        return "image/png", data
    picture = Image.open(io.BytesIO(data)).convert("RGB")
    while True:
        for quality in (90, 85, 80, 75):
            file = io.BytesIO()
            picture.save(file, "jpeg", quality=quality, optimize=True)
            if len(file.getvalue()) <= LARGEST:
                return "image/jpeg", file.getvalue()
        width, height = picture.size
        picture = picture.resize((9 * width // 10, 9 * height // 10), Image.Resampling.LANCZOS)


def small_address(found: re.Match[str]) -> str:
    """Address that holds a picture of a table, made small."""
    kind, data = small_picture(base64.b64decode(found[1]))
    return f"data:{kind};base64,{base64.b64encode(data).decode()}"


def small_output(output: nbformat.NotebookNode) -> nbformat.NotebookNode:
    """An output with small pictures."""
    data = output.get("data", {})
    if "image/png" in data:
        kind, file = small_picture(base64.b64decode(data.pop("image/png")))
        data[kind] = base64.b64encode(file).decode()
    if "text/html" in data:
        data["text/html"] = re.sub(
            r"data:image/png;base64,([\w+/=]+)", small_address, data["text/html"]
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
