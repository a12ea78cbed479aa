"""The scenes that `new --from` copies are those of sims/, and the wheel takes each of them along."""

import tomllib
from pathlib import Path

from astroinertia.storage.data_tables import ACCOMPANIED, scenes

ROOT = Path(__file__).parents[3]


def test_every_scene_that_stands_alone_is_offered_and_is_in_the_wheel() -> None:
    there = {path.stem: path for path in (ROOT / "sims").glob("*.toml")}
    assert set(scenes()) == set(there) - ACCOMPANIED and set(there) > ACCOMPANIED
    assert list(scenes()) == sorted(scenes())
    wheel = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["hatch"]["build"]["targets"]["wheel"]
    shipped = {to: one for one, to in wheel["force-include"].items() if one.startswith("sims/")}
    assert shipped == {f"astroinertia/sims/{name}.toml": f"sims/{name}.toml" for name in scenes()}


def test_what_is_offered_names_no_file_beside_it() -> None:
    for name, path in scenes().items():
        text = path.read_text()
        assert not any(line.split("#")[0].lstrip().startswith(("file =", "archive =")) for line in text.splitlines()), (
            name
        )
