"""How far a run is, on a console that main.py gives."""

import math
import threading
import time
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.text import Text

from astroinertia.ledger.bounds import doubtful

if TYPE_CHECKING:
    from astroinertia.run.loop import Progress

SECONDS_BETWEEN_LINES = 10.0  # where the output is no terminal
LONGEST_SILENCE = 8.0  # seconds; then a line says that work goes on
PREPARING = "preparing the body: placing and settling it, compiling"


class Voice:
    """Prints what is being done where nothing else has been printed for a while, in a thread of its own."""

    def __init__(self, console: Console, doing: str) -> None:
        self.console, self.doing = console, doing
        self.begun = self.spoken = time.monotonic()
        self.ended = threading.Event()
        self.speaker = threading.Thread(target=self._speak, name="voice", daemon=True)

    def __enter__(self) -> "Voice":
        self.speaker.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.ended.set()
        self.speaker.join()

    def begin(self, doing: str) -> None:
        """What is being done from now on."""
        self.doing = doing

    def say(self, line: str) -> None:
        """Print a line."""
        self.console.print(Text(line), soft_wrap=True)
        self.spoken = time.monotonic()

    def _speak(self) -> None:
        while not self.ended.wait(max(0.1, self.spoken + LONGEST_SILENCE - time.monotonic())):
            now = time.monotonic()
            if now - self.spoken >= LONGEST_SILENCE:
                self.say(f"{now - self.begun:.0f} s: {self.doing}")


class Meter:
    """Shows how far a run is: a bar with time to go on a terminal, a line now and then elsewhere."""

    def __init__(self, console: Console) -> None:
        self.console = console
        self.bar: Any = None  # a rich Progress, once there is something to show
        self.task: Any = None
        self.last_line = float("-inf")
        self.part = ""
        self.voice = Voice(console, PREPARING)

    def __enter__(self) -> "Meter":
        if self.console.is_terminal:
            self._opened().update(self.task, figures=PREPARING)
        else:
            self.voice.__enter__()
        return self

    def __exit__(self, *_: object) -> None:
        if self.bar is None:
            self.voice.__exit__()
        else:
            self.bar.stop()

    def tell(self, progress: "Progress") -> None:
        """Show it."""
        shown = {
            "energy error": f"{progress.energy_error:.1e}",
            "ledger closure": f"{progress.ledger_closure:.1e}",
            "densest": f"{progress.density_max:.3g}",
        }
        parts = [f"{name} {value}" for name, value in shown.items() if value != "nan"]
        parts += filter(None, [doubtful(progress.ledger_closure, progress.energy_error)])
        parts += [f"step limited by {progress.limited_by}"] if progress.limited_by else []
        if math.isfinite(progress.planned_steps):
            parts += [f"WARNING: the plan was about {progress.planned_steps:.3g} steps"]
        figures = "  ".join([*([progress.part] if progress.part else []), f"step {progress.step}", *parts])
        self.voice.begin(f"after step {progress.step}")
        if progress.part != self.part:  # another run, whose time begins again
            self.part, self.last_line = progress.part, float("-inf")
        share = min(1.0, progress.time / progress.end)
        to_go = f"{progress.to_go:.0f} s to go  " if math.isfinite(progress.to_go) else ""
        if not self.console.is_terminal:
            if progress.wall_time - self.last_line >= SECONDS_BETWEEN_LINES or share >= 1.0:
                self.last_line = progress.wall_time
                self.voice.say(f"{100.0 * share:5.1f}%  {progress.wall_time:7.1f} s  {to_go}{figures}")
            return
        self._opened().update(self.task, completed=share, figures=figures, to_go=to_go)

    def _opened(self) -> Any:
        if self.bar is not None:
            return self.bar
        from rich.progress import (
            BarColumn,
            Progress,
            TaskProgressColumn,
            TextColumn,
            TimeElapsedColumn,
        )

        self.bar = Progress(
            BarColumn(24),
            TaskProgressColumn(),
            TimeElapsedColumn(),
            TextColumn("{task.fields[to_go]}{task.fields[figures]}"),
            console=self.console,
        )
        self.task = self.bar.add_task("", total=1.0, figures="", to_go="")
        self.bar.start()
        return self.bar
