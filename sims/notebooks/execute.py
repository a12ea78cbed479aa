"""Execute the notebooks: `python sims/notebooks/execute.py` writes an .ipynb beside each source, or those named.

Sources are Python files in jupytext's percent format. Each is executed by a kernel of its own, of the Python that runs
this file, and what is written holds nothing of the machine: no times, no paths, no names. Needs the extra `notebooks`.
"""

import argparse
import base64
import io
import os
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import jupytext
import nbformat
from jupyter_client.manager import KernelManager
from nbclient import NotebookClient
from PIL import Image

HERE = Path(__file__).parent
COLOURS = 128  # of a picture, a fifth of the size of all
LONGEST = 600  # s, of a cell on a machine that has other things to do
METADATA = {
    "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
    "language_info": {"name": "python"},
}


def sources() -> list[Path]:
    """The notebooks of this folder."""
    return sorted(path for path in HERE.glob("*.py") if path.name != Path(__file__).name)


def notebook(source: Path) -> nbformat.NotebookNode:
    """The notebook of a source, not executed; its cells are named by their number."""
    found = jupytext.read(source)
    for number, cell in enumerate(found.cells, start=1):
        cell.id, cell.metadata = f"cell-{number}", nbformat.NotebookNode()
    found.metadata = nbformat.from_dict(METADATA)
    found.nbformat, found.nbformat_minor = 4, 5
    return found


def executed(source: Path, before: str = "", after: str = "") -> nbformat.NotebookNode:
    """The notebook with what its cells gave; raises nbclient's CellExecutionError where one fails.

    before and after: code for the same kernel. The notebook is without the one, and ends with the other and its output.
    """
    found = notebook(source)
    extra = [nbformat.v4.new_code_cell(code, id=name) for name, code in (("before", before), ("after", after))]
    found.cells = [extra[0], *found.cells, extra[1]]
    with tempfile.TemporaryDirectory() as folder:
        # Sockets are files rather than ports, which a machine may not have to give; nothing is kept of the session.
        manager = KernelManager(kernel_name="python3", transport="ipc", connection_file=f"{folder}/kernel.json")
        client = NotebookClient(found, km=manager, timeout=LONGEST, record_timing=False, coalesce_streams=True)
        client.execute(cleanup_kc=True, env=os.environ | {"IPYTHONDIR": f"{folder}/ipython"}, cwd=str(source.parent))
    del found.cells[0]
    return found


def smaller(picture: str) -> str:
    """A PNG in base64 with a palette of few colours."""
    found, opened = io.BytesIO(), Image.open(io.BytesIO(base64.b64decode(picture)))
    opened.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE).save(found, "PNG", optimize=True)
    return base64.b64encode(found.getvalue()).decode()


def write(source: Path) -> Path:
    """Execute a source and write its notebook beside it."""
    found = executed(source)
    del found.cells[-1]
    target = source.with_suffix(".ipynb")
    for cell in found.cells:
        for output in cell.get("outputs", ()):
            if output.output_type == "stream" and output.name == "stderr":
                raise ValueError(f"{source.name} says what a reader should not have to see: {output.text}")
            if "image/png" in output.get("data", {}):
                output.data["image/png"] = smaller(output.data["image/png"])
    nbformat.write(found, target)
    return target


def main(arguments: Sequence[str] | None = None) -> None:
    """Write all notebooks, or those of the sources named."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("source", nargs="*", type=Path, help="sources; all of this folder without any")
    for source in parser.parse_args(arguments).source or sources():
        print(f"wrote {write(source)}")


if __name__ == "__main__":
    sys.exit(main())
