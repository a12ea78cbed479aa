"""Every cross-check of `astroinertia verify`; how long it takes is no test, for machines are shared."""

import importlib
import json

import pytest

from astroinertia.cli.main import main
from astroinertia.verify import comparison

# Computations that take most of the time, with the keys of what they find. One of the planets stays; test_exact_flows
# has an exact motion, and test_rebound a spin beside that of a body inside REBOUND.
LONG = {
    "exact_motions": {"riemann": ("riemann_",), "dyson": ("dyson_",), "dirichlet": ("dirichlet_",)},
    "rebound": {"tumbling_moon": ("tumbling_",)},
    "turning_planets": {"earth": ("integrated_luni_solar", "integrated_longitude", "integrated_obliquity")},
}


def rows_of_the_command(capsys) -> list[dict]:
    code = main(["verify", "--json"])
    content = json.loads(capsys.readouterr().out)
    assert (code == 0) == content["agree"]
    assert len({row["section"] for row in content["comparisons"]}) == 14
    return content["comparisons"]


def test_every_short_cross_check_agrees(monkeypatch, capsys):
    monkeypatch.setattr(comparison, "BESIDE", ("particles",))  # a second process would compute its sections whole
    for section, long in LONG.items():
        module = importlib.import_module(f"astroinertia.verify.{section}")
        short = tuple(each for each in module.COMPUTATIONS if each.__name__ not in long)
        assert len(short) == len(module.COMPUTATIONS) - len(long)
        monkeypatch.setattr(module, "COMPUTATIONS", short)
    left_out = {section: sum(long.values(), ()) for section, long in LONG.items()}
    for row in rows_of_the_command(capsys):
        expected = "not computed" if row["key"].startswith(left_out.get(row["section"], ())) else "agrees"
        assert row["verdict"] == expected, row


@pytest.mark.full(inputs=["data/verify.csv"])
def test_every_cross_check_agrees(capsys):
    assert {row["verdict"] for row in rows_of_the_command(capsys)} == {"agrees"}
