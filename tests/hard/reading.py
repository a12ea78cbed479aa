"""A process that reads files which may be malformed, asked from outside, and replaced when one of them ends it."""

import json
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


class Reading:
    """`of(kind, path)` says what became of a file; see malformed_child.py."""

    def __init__(self):
        self.child = None

    def of(self, kind, path):
        if self.child is None:
            paths = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
            self.child = subprocess.Popen(
                [sys.executable, "-m", "tests.hard.malformed_child"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL, text=True, env={**os.environ, "PYTHONPATH": paths},
            )  # fmt: skip
            self.child.stdout.readline()  # it has imported everything
        self.child.stdin.write(json.dumps({"kind": kind, "path": str(path)}) + "\n")
        self.child.stdin.flush()
        answer = self.child.stdout.readline()
        if answer:
            return json.loads(answer)
        code, self.child = self.child.wait(), None
        return {"became": "death", "said": f"exit code {code}", "seconds": 0.0, "bytes": 0}

    def close(self):
        if self.child is not None:
            self.child.stdin.close()
            self.child.wait()
            self.child.stdout.close()
            self.child = None
