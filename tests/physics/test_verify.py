"""Every cross-check of `astroinertia verify`; how long it takes is no test, for machines are shared."""

import json

from astroinertia.cli import main


def test_every_cross_check_agrees(capsys):
    assert main(["verify", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert {row["verdict"] for row in told["comparisons"]} == {"agrees"}
    assert len({row["section"] for row in told["comparisons"]}) == 14
