"""How far a run is: on a terminal, below a cell of a notebook, or in lines."""

import html
import math
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.text import Text

from astroinertia.errors import SceneError
from astroinertia.process.activity import current

if TYPE_CHECKING:
    from astroinertia.run.loop import Listener, Progress
    from astroinertia.scene.schema import Scene

SECONDS_BETWEEN_LINES = 6.0  # where the output is no terminal
LONGEST_SILENCE = 8.0  # seconds, longer than that: then a line says that work goes on
PREPARING = "preparing the body"


def preparing(scene: "Scene") -> str:
    """What is done before the first step, in words."""
    orbits = ", and finding the orbits of its companions" if scene.has_companions else ""
    return f"{PREPARING}: {'placing and settling it' if scene.model == 'sph' else 'compiling its motion'}{orbits}"


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


class Cell:
    """A bar and words below a cell of a notebook, which change as it goes; other outputs of the cell stay."""

    def __init__(self, words: str) -> None:
        from IPython.display import display

        self.handle: Any = display(self._shown(0.0, words), raw=True, display_id=True)

    def show(self, share: float, words: str) -> None:
        """Show another share, and other words."""
        self.handle.update(self._shown(share, words), raw=True)

    @staticmethod
    def _shown(share: float, words: str) -> dict[str, str]:
        text = f"{100.0 * share:3.0f} %  {words}"
        return {"text/plain": text, "text/html": f'<progress value="{share:.4f}"></progress> {html.escape(text)}'}


class Meter:
    """Shows how far something is: a bar on a terminal or in a notebook; elsewhere lines, and never long silence."""

    def __init__(self, console: Console, doing: str = PREPARING) -> None:
        self.voice = Voice(console, doing)
        self.bar: Any = None  # a rich Progress with one task, on a terminal
        self.cell: Cell | None = None  # in a notebook
        self.last_line = float("-inf")
        self.share = 0.0
        self.part = ""

    def __enter__(self) -> "Meter":
        if self.voice.console.is_jupyter:
            self.cell = Cell(self.voice.doing)
            return self
        if not self.voice.console.is_terminal:
            self.voice.__enter__()
            return self
        self.bar = _bar(self.voice.console)
        self.bar.add_task(self.voice.doing, total=1.0)
        self.bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self.bar is not None:
            self.bar.stop()
        elif self.cell is None:
            self.voice.__exit__()

    def show(self, share: float, words: str, line: str = "", seconds: float = math.nan) -> None:
        """Show how much is done, in words: beside the bar, or as a line.

        line: what is printed where there is no bar; seconds: since the beginning, where not every line is wanted.
        """
        self.voice.begin(words)
        if self.cell is not None:
            self.cell.show(share, words)
        elif self.bar is not None:
            self.bar.update(self.bar.task_ids[0], completed=share, description=words)
        elif line and (share == 1.0 > self.share or not seconds - self.last_line < SECONDS_BETWEEN_LINES):
            self.last_line = seconds
            self.voice.say(line)
        self.share = share

    def tell(self, progress: "Progress") -> None:
        """Show how far a run is."""
        from astroinertia.dataset.bounds import doubtful

        shown = {
            "energy error": f"{progress.energy_error:.1e}",
            "ledger closure": f"{progress.ledger_closure:.1e}",
            "densest": f"{progress.density_max:.3g} {progress.density_unit}".strip(),
        }
        parts = [f"{name} {value}" for name, value in shown.items() if not value.startswith("nan")]
        parts += filter(None, [doubtful(progress.ledger_closure, progress.energy_error)])
        parts += [f"step limited by {progress.limited_by}"] if progress.limited_by else []
        if math.isfinite(progress.planned_steps):
            parts += [f"WARNING: the plan was about {progress.planned_steps:.3g} steps"]
        figures = "  ".join([*([progress.part] if progress.part else []), f"step {progress.step}", *parts])
        if progress.part != self.part:  # another run, whose time begins again
            self.part, self.last_line = progress.part, float("-inf")
        share = 1.0 if math.isclose(progress.time, progress.end) else min(1.0, progress.time / progress.end)
        words = (f"{progress.to_go:.0f} s to go  " if math.isfinite(progress.to_go) else "") + figures
        self.show(share, words, f"{100.0 * share:5.1f}%  {progress.wall_time:7.1f} s  {words}", progress.wall_time)
        self.voice.begin(f"after step {progress.step}")

    def tell_members(self, standing: Any) -> None:
        """Show how far a sweep is (sweeps.ensemble.Standing)."""
        failed = f", {standing.failed} failed" if standing.failed else ""
        predictable = standing.done < standing.members and math.isfinite(standing.to_go)
        to_go = f", {standing.to_go:.0f} s to go" if predictable else ""
        words = f"{standing.done} of {standing.members} members{failed}{to_go}"
        self.show(standing.done / standing.members, words, f"{standing.seconds:7.1f} s  {words}", standing.seconds)


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
    words = Words("", table_column=shortened)
    # what a callback prints goes above the bar, and where stdout goes elsewhere, there
    return Progress(*columns, words, console=console, expand=True, redirect_stdout=sys.stdout.isatty())


@contextmanager
def watched(progress: Any, listener: "Listener | None", doing: str = PREPARING) -> Iterator[Meter | None]:
    """A meter of what is done meanwhile, on stderr, where it is wanted; None elsewhere.

    progress: whether it is; by default where stderr is a terminal, or in a notebook, and nothing else listens.
    SceneError for anything else.
    """
    if not (progress is None or isinstance(progress, bool)):
        raise SceneError(f"progress must be True, False or None, not {progress!r:.40}.")
    console = Console(stderr=True, highlight=False)
    by_itself = listener is None and (sys.stderr.isatty() or console.is_jupyter)
    if not (by_itself if progress is None else progress):
        yield None
        return
    with Meter(console, doing) as meter:
        yield meter
