"""Every cross-check of `astroinertia verify`, in the time that it promises."""

import json

from astroinertia.cli import main

LONGEST = 60.0  # s, on two cores


def test_every_cross_check_agrees_in_under_a_minute(capsys):
    assert main(["verify", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert {row["verdict"] for row in told["comparisons"]} == {"agrees"}
    assert told["seconds"] < LONGEST
