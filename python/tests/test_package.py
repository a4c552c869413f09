"""The package as it is installed, and what is written about it."""

from __future__ import annotations

import contextlib
import io
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT

import crosscut


def test_the_import_takes_numpy_alone() -> None:
    script = "import sys, crosscut; print(sorted({m.split('.')[0] for m in sys.modules} & set(sys.argv)))"
    known = ["numpy", "scipy", "sklearn", "pyarrow", "networkx", "pandas"]
    done = subprocess.run([sys.executable, "-c", script, *known], capture_output=True, text=True, check=True)
    assert done.stdout == "['numpy']\n"


def test_modules_need_no_import_of_their_own() -> None:
    script = "import crosscut; print(crosscut.testing.check_affinity.__name__, hasattr(crosscut, 'none'))"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout == "check_affinity False\n"


def test_the_package_is_typed_and_of_one_version() -> None:
    assert Path(crosscut.__file__).with_name("py.typed").exists()
    assert f'version = "{crosscut.__version__}"' in (ROOT / "Cargo.toml").read_text()


def test_the_native_half_has_what_its_stub_declares(tmp_path: Path) -> None:
    (tmp_path / "allowed").write_text("crosscut\\._native\\.__all__\n")
    command = [sys.executable, "-m", "mypy.stubtest", "crosscut._native", "--allowlist", str(tmp_path / "allowed")]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stdout


def test_the_reference_of_python_names_what_there_is() -> None:
    page = subprocess.run([sys.executable, ROOT / "lab/python_reference.py"], capture_output=True, text=True, check=True).stdout
    written = (ROOT / "docs/python-reference.md").read_text()
    assert written == page, "`lab/make reference` makes the page"


def snippets(page: str) -> list[str]:
    return re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(), re.DOTALL)


@pytest.mark.parametrize("page", ["docs/python.md"])
def test_the_snippets_of_the_documentation_run(page: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "recordings").symlink_to(ROOT / "recordings")
    names: dict[str, object] = {"np": np}
    assert snippets(page)
    for snippet in snippets(page):
        with contextlib.redirect_stdout(io.StringIO()) as out:
            exec(snippet, names)
        shown = re.findall(r"^print\(.*#> (.*)$", snippet, re.MULTILINE)
        assert out.getvalue().splitlines() == shown
