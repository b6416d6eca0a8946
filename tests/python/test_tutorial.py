"""docs/tutorial.md: its programs in Python and in C++ run, and print what it says; so does the notebook in examples."""
import json
import os
import re
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs/tutorial.md").read_text()
EXAMPLE = Path(os.environ["PROXIMA_BUILD"]) / "examples/tutorial"


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)


def test_each_step_is_there_in_both_languages():
    assert len(blocks("python")) == len(blocks("cpp")) == len(blocks("text")) == 7


def test_python_prints_what_the_page_says(tmp_path):
    done = subprocess.run([sys.executable, "-W", "error", "-c", "\n".join(blocks("python"))], cwd=tmp_path, capture_output=True,
                          text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout == "".join(blocks("text"))
    assert (tmp_path / "octree.vtu").stat().st_size > 1000


def test_the_program_in_cpp_is_the_page_s():
    source = (ROOT / "examples/tutorial.cpp").read_text()
    body = re.search(r"int tutorial\(\)\n\{\n(.*?)\n    return 0;\n\}\n", source, re.DOTALL)[1]
    assert textwrap.dedent(body) == "\n".join(blocks("cpp")).rstrip()


@pytest.mark.skipif(not EXAMPLE.exists(), reason="the examples are not built")
def test_cpp_prints_what_the_page_says(tmp_path):
    done = subprocess.run([EXAMPLE], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout == "".join(blocks("text"))


def test_the_notebook_has_the_programs_of_the_page_and_what_they_print():
    notebook = json.loads((ROOT / "examples/tutorial.ipynb").read_text())
    assert (notebook["nbformat"], notebook["nbformat_minor"]) == (4, 5)
    cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    assert ["".join(cell["source"]) + "\n" for cell in cells] == blocks("python")
    assert [["".join(output["text"]) for output in cell["outputs"]] for cell in cells] == [[text] for text in blocks("text")]
    ids = [cell["id"] for cell in notebook["cells"]]
    assert len(set(ids)) == len(ids)


def test_the_notebook_runs_cell_by_cell(tmp_path, monkeypatch, capsys):
    """As Jupyter runs it: cells in order, in one namespace. Jupyter itself is not needed."""
    monkeypatch.chdir(tmp_path)
    names = {"__name__": "__main__"}
    for cell in json.loads((ROOT / "examples/tutorial.ipynb").read_text())["cells"]:
        if cell["cell_type"] == "code":
            exec(compile("".join(cell["source"]), cell["id"], "exec"), names)
            assert capsys.readouterr().out == "".join(cell["outputs"][0]["text"])
