"""Every cross-check of `astroinertia verify`, in the time that it promises."""

import json
import time

from astroinertia.cli import main

LONGEST = 60.0  # s of the processors: what it takes where nothing else runs, or less


def test_every_cross_check_agrees_in_under_a_minute(capsys):
    before = time.process_time()
    assert main(["verify", "--json"]) == 0
    assert time.process_time() - before < LONGEST
    told = json.loads(capsys.readouterr().out)
    assert {row["verdict"] for row in told["comparisons"]} == {"agrees"}
    assert len({row["section"] for row in told["comparisons"]}) == 14
