"""How far a run is, on a console that main.py gives."""

import math
import threading
import time
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.text import Text

from astroinertia.process.activity import current

if TYPE_CHECKING:
    from astroinertia.run.loop import Progress

SECONDS_BETWEEN_LINES = 10.0  # where the output is no terminal
LONGEST_SILENCE = 8.0  # seconds; then a line says that work goes on
PREPARING = "preparing the body: placing and settling it"


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
                self.say(f"{now - self.begun:.0f} s: {current() or self.doing}")


class Meter:
    """Shows how far something is: a bar on a terminal; elsewhere a line now and then, and never long silence."""

    def __init__(self, console: Console, doing: str = PREPARING) -> None:
        self.voice = Voice(console, doing)
        self.bar: Any = None  # a rich Progress with one task, on a terminal
        self.last_line = float("-inf")
        self.part = ""

    def __enter__(self) -> "Meter":
        if not self.voice.console.is_terminal:
            self.voice.__enter__()
            return self
        self.bar = _bar(self.voice.console)
        self.bar.add_task(self.voice.doing, total=1.0)
        self.bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.voice.__exit__() if self.bar is None else self.bar.stop()

    def show(self, share: float, words: str, line: str = "", seconds: float = math.nan) -> None:
        """Show how much is done, in words: beside the bar, or as a line.

        line: what is printed where there is no bar; seconds: since the beginning, where not every line is wanted.
        """
        self.voice.begin(words)
        if self.bar is not None:
            self.bar.update(self.bar.task_ids[0], completed=share, description=words)
        elif line and not (share < 1.0 and seconds - self.last_line < SECONDS_BETWEEN_LINES):
            self.last_line = seconds
            self.voice.say(line)

    def tell(self, progress: "Progress") -> None:
        """Show how far a run is."""
        from astroinertia.ledger.bounds import doubtful

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
        if progress.part != self.part:  # another run, whose time begins again
            self.part, self.last_line = progress.part, float("-inf")
        share = min(1.0, progress.time / progress.end)
        words = (f"{progress.to_go:.0f} s to go  " if math.isfinite(progress.to_go) else "") + figures
        self.show(share, words, f"{100.0 * share:5.1f}%  {progress.wall_time:7.1f} s  {words}", progress.wall_time)
        self.voice.begin(f"after step {progress.step}")


def _bar(console: Console) -> Any:
    """A bar, the share, the time and words, of which only the words are shortened on a narrow terminal."""
    from rich.progress import BarColumn, Progress, Task, TaskProgressColumn, TextColumn, TimeElapsedColumn
    from rich.table import Column

    class Words(TextColumn):
        """What goes on now: what the process is busy with, or what was said last."""

        def render(self, task: Task) -> Text:
            return Text(current() or task.description)

    whole, shortened = Column(no_wrap=True, min_width=7), Column(no_wrap=True, overflow="ellipsis", ratio=1)
    columns = BarColumn(24), TaskProgressColumn(table_column=whole), TimeElapsedColumn(table_column=whole.copy())
    return Progress(*columns, Words("", table_column=shortened), console=console, expand=True)
