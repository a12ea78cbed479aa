"""The command line: the only file that prints or exits. Heavy modules are imported by the commands that need them."""

import argparse
import os
import select
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext, suppress
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from rich.console import Console
from rich.text import Text

from astroinertia.cli import (
    audit,
    calibrate as cli_calibrate,
    choice,
    compare,
    export,
    guide as cli_guide,
    hard,
    hosts,
    moments,
    movie,
    pages,
    plan as cli_plan,
    ratios,
    result as cli_result,
    stop,
    sweep as cli_sweep,
    tradeoff as cli_tradeoff,
    verify as cli_verify,
)
from astroinertia.cli.help import DESCRIPTION, EXAMPLES
from astroinertia.cli.meter import Meter, Voice
from astroinertia.cli.screen import visible
from astroinertia.errors import ArchiveError, AstroinertiaError, RunInterrupted, SceneError
from astroinertia.process import interrupts, kept_programs, requirements

if TYPE_CHECKING:
    from astroinertia.accuracy.tradeoff import Standing
    from astroinertia.scene.schema import Scene
    from astroinertia.scene.sweep import Sweep

GOOD, FAILED, BAD_INPUT, UNCLOSED, INTERRUPTED = 0, 1, 2, 3, stop.INTERRUPTED
SHOWN_CURSOR = b"\x1b[?25h\r\n"  # bars and spinners hide it
KEPT = "interrupted; what is done is kept: go on with the same command."


class _Console(Console):
    """A console that leaves a closed pipe to `main`, and shows what files say without what it would do to a screen."""

    def on_broken_pipe(self) -> None:
        raise BrokenPipeError

    def render(self, renderable, options=None):
        for segment in super().render(renderable, options):
            yield segment if segment.control else segment._replace(text=visible(segment.text))


class _Parser(argparse.ArgumentParser):
    """Says what is wrong with the arguments in one sentence."""

    def error(self, message: str) -> NoReturn:
        raise SceneError(f"{message}; `{self.prog} --help` tells more.")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return the exit code: 0 good, 1 failed, 2 bad input, 3 not closed, 130 stopped.

    A signal where nothing is to be sealed, or a second one, ends the process at once, with 128 and its number.
    """
    with interrupts.watched(_end):
        return _carried_out(arguments)


def _carried_out(arguments: Sequence[str] | None) -> int:
    try:
        options = _parser().parse_args(arguments)
        requirements.check()
        kept_programs.keep_apart()
        with stop.warnings_as_sentences(_complain), hosts.joined(options):
            return options.command(options)
    except RunInterrupted as stopped:
        _complain(stop.interruption_message(stopped))
        return INTERRUPTED
    except AstroinertiaError as error:
        _complain(_ended(str(error)))
        return BAD_INPUT if isinstance(error, SceneError | ArchiveError) else FAILED
    except BrokenPipeError:
        # the reader (head, less) has gone; without this, Python complains once more when it closes the stream
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return GOOD
    except MemoryError:
        _complain("there is not enough memory for this.")
        return FAILED
    except OSError as error:
        _complain(_ended(f"{error.filename or 'a file'}: {(error.strerror or str(error)).lower()}"))
        return FAILED


def _end(how: interrupts.Ended) -> NoReturn:
    """End this process from a thread beside the main one, which may hold any lock: that of a stream, too."""
    code, sentence = stop.ended(how)
    if sys.stdout.isatty():
        _written(1, SHOWN_CURSOR)
    _written(2, f"{_line(sentence)}\n".encode())
    interrupts.discard_leftovers()
    os._exit(code)


def _written(descriptor: int, text: bytes) -> None:
    if select.select([], [descriptor], [], 0.0)[1]:  # nobody may read it
        with suppress(OSError):
            os.write(descriptor, text)


def _complain(sentence: str) -> None:
    print(_line(sentence), file=sys.stderr)


def _line(sentence: str) -> str:
    return f"astroinertia: {visible(sentence, lines=False)}"


def _ended(sentence: str) -> str:
    return sentence if sentence.endswith(".") else f"{sentence}."


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="astroinertia",
        description=DESCRIPTION,
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="the version, and those of what it stands on")
    commands = parser.add_subparsers(metavar="COMMAND", required=True, parser_class=_Parser)

    new = _command(commands, "new", _new, "write a commented example scene", "astroinertia new star.toml")
    new.add_argument("file", nargs="?", metavar="FILE", type=Path, help="where to write it; to the screen without it")

    plan = _command(
        commands, "plan", _plan, "say what a scene calls for, why, and what it costs", "astroinertia plan star.toml"
    )
    _scene_arguments(plan)
    audit.add_arguments(plan)
    cli_calibrate.add_plan_arguments(plan)
    choice.add_arguments(plan)

    run = _command(
        commands,
        "run",
        _run,
        "run a scene",
        "astroinertia run star.toml --set body.particles=5000 --output runs/coarse",
    )
    _scene_arguments(run)
    run.add_argument("--output", type=Path, metavar="DIR", help="folder of the run, new or empty (default: runs/NAME)")
    choice.add_arguments(run)
    stop.add_arguments(run)
    hosts.add_arguments(run)
    cli_sweep.add_arguments(run)

    resume = _command(commands, "resume", _resume, "go on with an interrupted run", "astroinertia resume runs/coarse")
    resume.add_argument("run", metavar="RUN", type=Path, help="folder of the run")
    stop.add_arguments(resume)
    hosts.add_arguments(resume)
    cli_sweep.add_arguments(resume)

    show = _command(
        commands, "show", _show, "print a summary of a result and draw its pictures", "astroinertia show runs/coarse"
    )
    cli_result.add_argument(show, "file")
    show.add_argument("--output", type=Path, metavar="DIR", help="folder for the pictures (default: beside the file)")

    movie.add_arguments(_command(commands, "movie", _movie, "film a run", "astroinertia movie runs/coarse"))
    for name, action, text in (
        ("report", pages.report, "tell all of a run in one HTML file: scene, pictures, ledger, accuracy"),
        ("view", pages.view, "show the body of a run to turn about, in one HTML file"),
    ):
        page = _command(commands, name, _printing(name, action), text, f"astroinertia {name} runs/coarse")
        pages.add_arguments(page, name)

    tradeoff = _command(
        commands,
        "tradeoff",
        _tradeoff,
        "run a scene over its accuracy knobs and say what accuracy costs in time",
        "astroinertia tradeoff star.toml --minutes 10",
    )
    _scene_arguments(tradeoff)
    cli_tradeoff.add_arguments(tradeoff)

    printing = (
        ("compare", compare, "lay several runs over each other: models of one scene, or costs of one model",
         "runs/scaling runs/ellipsoid runs/particles"),
        ("moments", moments, "print the inertia tensor of a particle table, a mesh or a snapshot, and what follows "
         "from it", "particles.csv"),
        ("export", export, "write a result in the format of another program", "runs/coarse --to gadget"),
        ("ratios", ratios, "print the moment ratios of the solar system, measured against models", "--body Mars"),
    )  # fmt: skip
    for name, module, text, example in printing:
        module.add_arguments(
            _command(commands, name, _printing(name, module.report), text, f"astroinertia {name} {example}")
        )

    verify = _command(
        commands,
        "verify",
        _verify,
        "check this installation against REBOUND, astropy and published values, in under a minute",
        "astroinertia verify",
    )
    cli_verify.add_arguments(verify)
    hard.add_arguments(verify)

    calibrate = _command(
        commands, "calibrate", _calibrate, "measure this machine, so that plans tell how long runs take",
        "astroinertia calibrate",
    )  # fmt: skip
    cli_calibrate.add_arguments(calibrate)

    guide = _command(commands, "guide", _guide, "read the guide, page by page", "astroinertia guide ledger")
    cli_guide.add_arguments(guide)
    return parser


def _command(commands, name: str, action: Callable, text: str, example: str) -> argparse.ArgumentParser:
    command = commands.add_parser(
        name, help=text, description=f"{text[:1].upper()}{text[1:]}.", epilog=f"example: {example}", allow_abbrev=False
    )
    command.set_defaults(command=action)
    return command


def _printing(name: str, action: Callable[[argparse.Namespace], str]) -> Callable[[argparse.Namespace], int]:
    def printed(options: argparse.Namespace) -> int:
        with _voice(f"{name} is at work"):
            message = action(options)
        _say(message)
        return GOOD

    return printed


def _scene_arguments(command: argparse.ArgumentParser) -> None:
    command.add_argument("scene", metavar="SCENE", type=Path, help="scene file (TOML)")
    command.add_argument(
        "--set",
        dest="overrides",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help='set a key of the scene, such as body.particles=5000 or "time.end=2 s"; may be repeated',
    )


class _Version(argparse.Action):
    def __call__(self, parser, namespace, values, option_string=None) -> NoReturn:
        from importlib.metadata import PackageNotFoundError, version

        for name in ("astroinertia", "numpy", "numba", "jax", "xarray", "astropy"):
            try:
                _say(f"{name} {version(name)}")
            except PackageNotFoundError:
                _say(f"{name} not installed")
        parser.exit()


def _say(text: str, end: str = "\n") -> None:
    print(visible(text), end=end, flush=True)


def _voice(doing: str) -> Voice:
    return Voice(_Console(highlight=False, stderr=True), doing)


def _voice_unless_shown(console: Console, doing: str) -> AbstractContextManager[object]:
    """Where something moves on a terminal it says enough."""
    return nullcontext() if console.is_terminal else Voice(console, doing)


def _load(options: argparse.Namespace) -> "Scene":
    from astroinertia.scene.load import load_file

    return load_file(options.scene, options.overrides)


def _chosen(scene: "Scene", folder: Path, options: argparse.Namespace) -> "Scene":
    with interrupts.under_way(lambda by: KEPT, resumable=False), _voice("looking for the settings"):
        return choice.chosen(scene, folder, options.minutes, _say)


def _new(options: argparse.Namespace) -> int:
    from astroinertia.scene.example import example_text

    text = example_text()
    if options.file is None:
        _say(text, end="")
        return GOOD
    try:
        with options.file.open("x", encoding="utf-8") as stream:
            stream.write(text)
    except FileExistsError:
        raise SceneError(f"{options.file} is there already and is left as it is.") from None
    except (OSError, ValueError) as error:
        raise SceneError(f"{options.file} cannot be written ({getattr(error, 'strerror', None) or error}).") from None
    _say(f"wrote {options.file}; edit it, then: astroinertia plan {options.file}")
    return GOOD


def _plan(options: argparse.Namespace) -> int:
    from astroinertia.scene.plan import plan

    if (sweep := cli_sweep.asked(options)) is not None:
        _Console(highlight=False).print(*cli_plan.parts(cli_sweep.planned(sweep, options)), sep="\n")
        return GOOD
    scene = _load(options)
    if options.pilot:
        scene = _chosen(scene, Path("runs") / scene.name, options)
    with _voice("the plan is worked out"):
        costed = cli_calibrate.with_cost(plan(scene), scene, options, _say)
    _Console(highlight=False).print(*cli_plan.parts(costed), sep="\n")
    if not options.audit:
        return GOOD
    with _voice("importing") as voice:
        found = audit.audited(scene, voice.begin)
    _Console(highlight=False).print(audit.table(found))
    _say(audit.verdict(found))
    return GOOD if found.holds else FAILED


def _calibrate(options: argparse.Namespace) -> int:
    with _voice("a probe is at work"):
        _say(cli_calibrate.report(options, _say))
    return GOOD


def _run(options: argparse.Namespace) -> int:
    begun = time.monotonic()  # what imports take is part of a run's time
    if (sweep := cli_sweep.asked(options)) is not None:
        return _sweep(sweep, options.output or Path("runs") / sweep.name, options, stop.deadline(options, begun))
    scene = _load(options)
    folder = options.output or Path("runs") / scene.name
    from astroinertia.accuracy.running import run_scene

    scene = _chosen(scene, folder, options)
    _say(f"{scene.name}: model {scene.model}, effects {', '.join(scene.effects) or 'none'}; preparing the body")
    with Meter(_Console(highlight=False)) as meter:
        result = run_scene(scene, folder, meter.tell, begun, stop.deadline(options, begun))
    return _finished(result, folder)


def _resume(options: argparse.Namespace) -> int:
    limit = stop.deadline(options)
    from astroinertia.accuracy.running import resume

    if cli_sweep.is_folder(options.run):
        from astroinertia.sweeps.folder import read

        return _sweep(read(options.run), options.run, options, limit)
    cli_sweep.refuse_options(options)
    with Meter(_Console(highlight=False)) as meter:
        result = resume(options.run, meter.tell, limit)
    return _finished(result, options.run)


def _sweep(sweep: "Sweep", folder: Path, options: argparse.Namespace, deadline: float) -> int:
    console = _Console(highlight=False)
    with _voice_unless_shown(console, "members are at work"):
        found = cli_sweep.carry_out(sweep, folder, options, deadline, console, _say)
    unclosed = cli_sweep.unclosed(found.file)
    for line in (*cli_sweep.failures(sweep, found), *unclosed):
        _say(line)
    _say(f"wrote {found.file}; look at it with: astroinertia show {folder}")
    return FAILED if found.failures else UNCLOSED if unclosed else GOOD


def _finished(result: Path, folder: Path) -> int:
    from astroinertia import dataset
    from astroinertia.dataset import resolution
    from astroinertia.ledger import bounds

    attrs = dataset.open(result).attrs
    unclosed = bounds.ledger_message(attrs)
    for message in (resolution.resolution_message(attrs), unclosed, cli_calibrate.compared(attrs)):
        if message:
            _say(message)
    _say(f"wrote {result}; look at it with: astroinertia show {folder}")
    return UNCLOSED if unclosed else GOOD


def _guide(options: argparse.Namespace) -> int:
    if options.topic is None:
        _say(cli_guide.topics())
        return GOOD
    text = cli_guide.pages.readable(options.topic)
    if not sys.stdout.isatty():
        _say(text, end="")
        return GOOD
    console = _Console(highlight=False)
    shown = cli_guide.rendered(text, console.width, console.color_system is not None and not console.no_color)
    if not cli_guide.paged(shown):
        print(shown, end="")
    return GOOD


def _show(options: argparse.Namespace) -> int:
    from astroinertia import plots

    if cli_sweep.is_folder(options.file):
        _say("\n".join(cli_sweep.summary(options.file)))
        return GOOD
    opened = cli_result.opened(options.file)
    with cli_result.shown(options.file), _voice("pictures are drawn"):
        _say(plots.summary(opened))
        written = plots.write_all(opened, options.output or cli_result.beside(options.file))
    _say("pictures:")
    for path in written:
        _say(f"  {path}")
    return GOOD


def _movie(options: argparse.Namespace) -> int:
    console = _Console(highlight=False)
    with _voice_unless_shown(console, "frames are drawn"), movie.Bar(console) as bar:
        message = movie.carry_out(options, bar.tell)
    _say(message)
    return GOOD


def _tradeoff(options: argparse.Namespace) -> int:
    console = _Console(highlight=False)

    def tell(standing: "Standing") -> None:
        line = f"{standing.done} of {standing.settings} settings, {standing.spent:.0f} of {standing.budget:.0f} s"
        status.update(Text(f"{line}: {standing.now}"))
        if not console.is_terminal:
            _say(f"{line}: {standing.now}")

    begun = interrupts.under_way(lambda by: KEPT)
    beside = _voice_unless_shown(console, "settings are tried")
    with begun, beside, console.status("looking for the exact answer") as status:
        lines, interrupted = cli_tradeoff.carry_out(_load(options), options, tell)
    console.print(Text("\n".join(lines)), soft_wrap=True)
    if interrupted:
        _complain(KEPT)
        return INTERRUPTED
    return GOOD


def _verify(options: argparse.Namespace) -> int:
    console = _Console(highlight=False)
    if not console.is_terminal:
        console = _Console(highlight=False, width=cli_verify.WIDTH)
    with interrupts.under_way(lambda by: "interrupted.", resumable=False):
        return _verify_hard(options, console) if options.hard else _verify_sections(options, console)


def _verify_sections(options: argparse.Namespace, console: Console) -> int:
    found, begun = [], time.monotonic()
    with _voice("importing") as voice:
        for section in cli_verify.sections(options, voice.begin):
            found.append(section)
            if not options.json:
                console.print(cli_verify.table(section, console.width))
    _say(cli_verify.as_json(found) if options.json else cli_verify.total(found, time.monotonic() - begun))
    return GOOD if all(section.holds for section in found) else FAILED


def _verify_hard(options: argparse.Namespace, console: Console) -> int:
    found: hard.Rows = []
    with _voice("importing") as voice:
        for title, rows in hard.families(options, voice.begin):
            found += rows
            if not options.json:
                console.print(hard.table(title, rows))
    _say(hard.as_json(found) if options.json else hard.total(found))
    return GOOD if all(each.holds for verdicts in found for each in verdicts) else FAILED


if __name__ == "__main__":
    sys.exit(main())
