"""The command line: the only file that prints or exits. Heavy modules are imported by the commands that need them."""

import argparse
import io
import os
import select
import shlex
import shutil
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from rich.console import Console
from rich.text import Text

from astroinertia.cli import (
    audit,
    branch as cli_branch,
    calibrate as cli_calibrate,
    choice,
    compare,
    completion,
    export,
    guide as cli_guide,
    hard,
    hosts,
    moments,
    movie,
    new as cli_new,
    plan as cli_plan,
    precession,
    ratios,
    reports,
    result as cli_result,
    sensitivity as cli_sensitivity,
    show,
    stop,
    sweep as cli_sweep,
    tradeoff as cli_tradeoff,
    verify as cli_verify,
)
from astroinertia.cli.parser import Add, Command, Options, add_scene, add_settings, parser_of
from astroinertia.cli.screen import visible
from astroinertia.errors import SAID, ArchiveError, AstroinertiaError, RunInterrupted, SceneError
from astroinertia.process import interrupts, kept_programs, requirements
from astroinertia.process.cache_directory import cache_directory
from astroinertia.process.uncollected import uncollected
from astroinertia.run.meter import Meter, Voice, preparing

if TYPE_CHECKING:
    from astroinertia.accuracy.tradeoff import Standing
    from astroinertia.run.profile import Profile
    from astroinertia.scene.schema import Scene
    from astroinertia.scene.sweep import Sweep

GOOD, FAILED, BAD_INPUT, UNCLOSED, INTERRUPTED = 0, 1, 2, 3, stop.INTERRUPTED
SHOWN_CURSOR = b"\x1b[?25h\r\n"  # bars and spinners hide it
KEPT = "interrupted; what is done is kept: go on with the same command."


class _Console(Console):
    """A console that leaves a closed pipe to `main`, and shows what files say without what it would do to a screen."""

    def on_broken_pipe(self) -> None:
        raise BrokenPipeError

    def print(self, *objects, **options) -> None:
        with _named():
            super().print(*objects, **options)

    def render(self, renderable, options=None):
        for segment in super().render(renderable, options):
            yield segment if segment.control else segment._replace(text=visible(segment.text))


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return the exit code: 0 good, 1 failed, 2 bad input, 3 not closed, 130 stopped.

    A signal where nothing is to be saved, or a second one, ends the process at once, with 128 and its number.
    """
    if isinstance(sys.stdout, io.TextIOWrapper):  # a terminal that has no such character shows another for it
        sys.stdout.reconfigure(errors="replace")
    with interrupts.watched(_end):
        return _carried_out(arguments)


def _carried_out(arguments: Sequence[str] | None) -> int:
    words = sys.argv[1:] if arguments is None else arguments
    if hosts.left_to_the_first(words):
        return GOOD
    try:
        with hosts.parsed_alike(words):
            options = parser_of(_commands(), _Version).parse_args(words)
        requirements.check()
        kept_programs.keep(cache_directory() / "jax")
        with stop.warnings_as_sentences(_complain), hosts.joined(options):
            return options.command(options)
    except RunInterrupted as stopped:
        _complain(stop.interruption_message(stopped), stopped)
        return INTERRUPTED
    except AstroinertiaError as error:
        _complain(_ended(str(error)), error)
        return BAD_INPUT if isinstance(error, SceneError | ArchiveError) else FAILED
    except BrokenPipeError:
        # the reader (head, less) has gone; without this, Python complains once more when it closes the stream
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return GOOD
    except MemoryError as error:
        _complain("there is not enough memory for this.", error)
        return FAILED
    except OSError as error:
        said = f"{error.filename or 'a file'}: {error.strerror.lower()}" if error.strerror else str(error)
        _complain(_ended(said), error)
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


def _complain(sentence: str, error: BaseException | None = None) -> None:
    if SAID not in getattr(error, "__notes__", ()):
        print(_line(sentence), file=sys.stderr)


def _line(sentence: str) -> str:
    return f"astroinertia: {visible(sentence, lines=False)}"


def _ended(sentence: str) -> str:
    return sentence if sentence.endswith((".", "?")) else f"{sentence}."


def _commands() -> dict[str, Command]:
    """The commands: function, what it does, end of its help, what adds its arguments."""
    sweeping = (stop.add_arguments, cli_sweep.add_arguments)
    running = (*sweeping, hosts.add_arguments)
    return {
        "new": Command(_new, "write a commented scene, or copy one that runs as it stands", cli_new.help_text(),
                       (cli_new.add_arguments,)),
        "plan": Command(_plan, "say what a scene calls for, why, and what it costs", "star.toml",
                        (add_scene, audit.add_arguments, cli_calibrate.add_plan_arguments, choice.add_arguments)),
        "run": Command(_run, "run a scene", f"{stop.EXIT_CODES}\nexample: astroinertia run star.toml "
                       "--set body.particles=5000 --output runs/coarse",
                       (add_scene, _add_run, choice.add_arguments, *running)),
        "warm": Command(_warm, "compile ahead what runs of a scene need", "star.toml --set body.particles=5000",
                        (add_scene,)),
        "resume": Command(_resume, "continue an interrupted run, or a finished one to a later end",
                          f'{stop.EXIT_CODES}\nexample: astroinertia resume runs/coarse --set "time.end=4 s"',
                          (_add_resume, *running)),
        "branch": Command(_branch, "start a run from a state of another one, with other effects or settings",
                          cli_branch.HELP, (cli_branch.add_arguments, stop.add_arguments)),
        "show": Command(_show, "print a summary of a result and draw its pictures", "runs/coarse",
                        (show.add_arguments,)),
        "movie": Command(_movie, "film a run", movie.HELP, (movie.add_arguments,)),
        "report": Command(_printing("report", reports.report), "describe a run in one HTML file: scene, pictures, "
                          "ledger, accuracy", "runs/coarse", (partial(reports.add_arguments, name="report"),)),
        "view": Command(_printing("view", reports.view), "write the body of a run as one HTML file, to turn about",
                        "runs/coarse", (partial(reports.add_arguments, name="view"),)),
        "tradeoff": Command(_tradeoff, "run a scene over its accuracy knobs and say what accuracy costs in time",
                            "star.toml --minutes 10", (add_scene, cli_tradeoff.add_arguments)),
        "sensitivity": Command(_sensitivity, "say how a run depends on keys of its scene: derivatives of every series",
                               cli_sensitivity.HELP, (cli_sensitivity.add_arguments, *sweeping)),
        "compare": Command(_printing("compare", compare.report), "compare several runs: models of one scene, or costs "
                           "of one model", compare.HELP, (compare.add_arguments,)),
        "moments": Command(_printing("moments", moments.report), "print the inertia tensor of a particle table, a mesh "
                           "or a snapshot, and what follows from it", moments.HELP, (moments.add_arguments,)),
        "export": Command(_printing("export", export.report), "write a result in the format of another program",
                          export.HELP, (export.add_arguments,)),
        "ratios": Command(_printing("ratios", ratios.report), "print the moment ratios of the solar system, measured "
                          "against models", ratios.HELP, (ratios.add_arguments,)),
        "precession": Command(_printing("precession", precession.report), "print how fast a body's axis precesses, and "
                              "the share of each companion", precession.HELP, (precession.add_arguments,)),
        "verify": Command(_verify, "check this installation against REBOUND, astropy and published values, in under a "
                          "minute", cli_verify.HELP, (cli_verify.add_arguments, hard.add_arguments)),
        "calibrate": Command(_calibrate, "measure this machine, so that plans predict how long runs take",
                             cli_calibrate.HELP),
        "guide": Command(_guide, "read the guide, page by page", "ledger", (cli_guide.add_arguments,)),
        "completion": Command(_completion, "print what a shell needs to complete commands, options and files",
                              completion.HELP, (completion.add_arguments,)),
    }  # fmt: skip


def _add_run(add: Add) -> None:
    add("--output", type=Path, metavar="DIR", help="folder of the run, without another run in it (default: runs/NAME)")
    add("--profile", action="store_true", help="time the parts of the run, which `show` then prints")


def _add_resume(add: Add) -> None:
    add("run", metavar="RUN", type=Path, help="folder of the run")
    add_settings(add, 'go on with another end, such as "time.end=4 s" or time.max_steps=5000, or with other outputs, '
        'such as "output.series_every=1 ms"; may be repeated')  # fmt: skip


def _printing(name: str, action: Callable[[Options], str]) -> Callable[[Options], int]:
    def printed(options: Options) -> int:
        with _voice(f"{name} is at work"):
            message = action(options)
        _say(message)
        return GOOD

    return printed


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
    with _named():
        print(visible(text), end=end, flush=True)


@contextmanager
def _named() -> Iterator[None]:
    """Say of an error that it is of the standard output; that nobody reads on, as behind `head`, is none."""
    try:
        yield
    except BrokenPipeError:
        raise
    except OSError as error:
        raise OSError(error.errno, error.strerror, "standard output") from error


def _voice(doing: str) -> Voice:
    return Voice(_Console(highlight=False, stderr=True), doing)


def _load(options: Options) -> "Scene":
    from astroinertia.scene.load import load_file

    return load_file(options.scene, options.overrides)


def _chosen(scene: "Scene", folder: Path, options: Options) -> "Scene":
    with interrupts.under_way(lambda by: KEPT, resumable=False), _voice("looking for the settings"):
        return choice.chosen(scene, folder, options.minutes, _say)


def _new(options: Options) -> int:
    text = cli_new.text(options)
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
    _say(f"wrote {options.file}; edit it, then: astroinertia plan {shlex.quote(str(options.file))}")
    return GOOD


def _plan(options: Options) -> int:
    from astroinertia.scene.plan import plan

    if (sweep := cli_sweep.sweep_of(options)) is not None:
        cli_calibrate.refuse_processes(options, None)
        choice.refuse_minutes(options, cli_sweep.scenes(sweep))
        with _voice("the members are checked"):
            planned, possible = cli_sweep.planned(sweep, options)
        _Console(highlight=False).print(*cli_plan.parts(planned), sep="\n")
        return GOOD if possible else BAD_INPUT
    scene = _load(options)
    cli_calibrate.refuse_processes(options, scene)
    cli_calibrate.refuse_pilot(options, scene)
    choice.refuse_minutes(options, [scene])
    from astroinertia.build.assemble import refuse_contradictions

    with _voice("the body is checked"):
        refuse_contradictions(scene)
        if scene.judged_by:
            from astroinertia.accuracy.selected_observables import parsed  # only here: it imports xarray

            _ = [parsed(name, scene.observables) for name in scene.judged_by]
    if options.pilot:
        scene = _chosen(scene, Path("runs") / scene.name, options)
    with _voice("the plan is worked out"):
        costed = cli_calibrate.with_cost(plan(scene), scene, options, _say)
    _Console(highlight=False).print(*cli_plan.parts(costed), sep="\n")
    if not options.audit:
        return GOOD
    with _voice("importing") as voice:
        audited = audit.audited(scene, voice.begin)
    _Console(highlight=False).print(audit.table(audited))
    _say(audit.verdict(audited))
    return GOOD if audited.holds else FAILED


def _calibrate(_: Options) -> int:
    with _voice("a probe is at work"):
        _say(cli_calibrate.report(_say))
    return GOOD


def _run(options: Options) -> int:
    begun = time.monotonic()  # what imports take is part of a run's time
    if (sweep := cli_sweep.sweep_of(options)) is not None:
        if options.profile:
            raise SceneError("--profile is for one run, and this scene is swept.")
        choice.refuse_minutes(options, cli_sweep.scenes(sweep))
        return _sweep(sweep, options.output or Path("runs") / sweep.name, options, stop.deadline(options, begun))
    scene = _load(options)
    choice.refuse_minutes(options, [scene])
    folder = options.output or Path("runs") / scene.name
    from astroinertia.accuracy.running import run_scene
    from astroinertia.process.freed_memory import keep_freed_memory
    from astroinertia.run.loop import refuse_before
    from astroinertia.scene.plan_body import unstated_wobble

    keep_freed_memory()
    with _voice("the body is checked"):
        refuse_before(scene, folder)
    before = time.monotonic()
    scene = _chosen(scene, folder, options)
    limit = stop.deadline(options, begun)
    begun += time.monotonic() - before  # what pilots take is none of it
    _say(f"{scene.name}: model {scene.model}, effects {', '.join(scene.effects) or 'none'}; preparing the body")
    if wobble := unstated_wobble(scene):
        _say(wobble)
    with Meter(_Console(highlight=False), preparing(scene)) as meter, _profile(options, begun) as profile:
        result = run_scene(scene, folder, meter.tell, begun, limit, profile=profile)
    return _finished(result, folder)


def _profile(options: Options, begun: float) -> "AbstractContextManager[Profile | None]":
    if not options.profile:
        return nullcontext()
    from astroinertia.run.profile import Profile

    return Profile(begun)


def _warm(options: Options) -> int:
    scene = _load(options)
    from astroinertia.run.warm import warm

    try:
        with _voice("programs are compiled"):
            compiled = warm(scene)
    except RunInterrupted:
        _complain(KEPT)
        return INTERRUPTED
    names, processor = compiled.programs, f"{compiled.processor:.1f} s of processor time"
    here = ", and others by a second process" if compiled.beside else ""
    _say(f"compiled {len(names)} programs{here}{': ' if names else ''}{', '.join(names)}")
    _say(f"took {compiled.wall:.1f} s ({processor}), {compiled.compiling:.1f} s to compile")
    return GOOD


def _resume(options: Options) -> int:
    limit = stop.deadline(options)
    from astroinertia.accuracy.running import resume
    from astroinertia.process.freed_memory import keep_freed_memory
    from astroinertia.storage.archive import Archive

    if cli_sweep.is_folder(options.run):
        from astroinertia.sweeps.folder import read

        if options.overrides:
            raise SceneError("a sweep goes on as it began: --set is for a run.")

        return _sweep(read(options.run), options.run, options, limit)
    Archive.view(options.run)  # what is no run is said before what a run has no use for
    cli_sweep.refuse_options(options)
    keep_freed_memory()
    with Meter(_Console(highlight=False)) as meter:
        result = resume(options.run, meter.tell, limit, settings=options.overrides)
    return _finished(result, options.run)


def _branch(options: Options) -> int:
    begun = time.monotonic()
    limit = stop.deadline(options, begun)
    from astroinertia.process.freed_memory import keep_freed_memory
    from astroinertia.run.branch import branch

    if cli_sweep.is_folder(options.run):
        from astroinertia.scene.sweep import member

        raise SceneError(f"{options.run} is a sweep; branch one of its members, such as {options.run / member(0)}.")
    keep_freed_memory()
    with Meter(_Console(highlight=False)) as meter:
        result = branch(
            options.run, options.output, options.at, options.overrides,
            listener=meter.tell, begun=begun, deadline=limit,
        )  # fmt: skip
    from astroinertia import dataset

    _say(dataset.open(result).attrs["history"].splitlines()[-1].partition(": ")[2])
    return _finished(result, options.output)


def _sweep(sweep: "Sweep", folder: Path, options: Options, deadline: float) -> int:
    with Meter(_Console(highlight=False), "members are at work") as meter:
        outcome = cli_sweep.carry_out(sweep, folder, options, deadline, meter, _say)
    unclosed = cli_sweep.unclosed(outcome.file)
    for line in (*cli_sweep.failures(sweep, outcome.failures), *cli_sweep.early(outcome.file), *unclosed):
        _say(line)
    _say(f"wrote {outcome.file}; look at it with: astroinertia show {shlex.quote(str(folder))}")
    return FAILED if outcome.failures else UNCLOSED if unclosed else GOOD


def _sensitivity(options: Options) -> int:
    begun = time.monotonic()
    scene = _load(options)
    sweep, folder = cli_sensitivity.sweep_of(scene, options)
    code = _sweep(sweep, folder, options, stop.deadline(options, begun))
    if code == FAILED:
        return code
    _say("\n".join(cli_sensitivity.report(scene, folder, folder / f"{sweep.name}.nc", options)))
    return code


def _finished(result: Path, folder: Path) -> int:
    from astroinertia import dataset
    from astroinertia.dataset import bounds

    attrs = dataset.open(result).attrs
    unclosed = bounds.message(attrs, "ledger")
    early = f"the run is over before its end: {attrs['ended_early']}" if "ended_early" in attrs else ""
    bars = str(attrs.get("error_bars_comment", ""))
    for message in (early, bounds.message(attrs, "resolution"), unclosed, bars, cli_calibrate.compared(attrs)):
        if message:
            _say(message)
    _say(f"wrote {result}; look at it with: astroinertia show {shlex.quote(str(folder))}")
    return UNCLOSED if unclosed else GOOD


def _guide(options: Options) -> int:
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


@uncollected()
def _show(options: Options) -> int:
    from astroinertia import plots

    sweep = cli_result.folder_of_sweep(options.file)
    if sweep is not None and options.member is None:
        if options.only or options.output is not None:
            raise SceneError("--only and --output are of the pictures of one run: add --member N, of this sweep.")
        _say("\n".join(cli_sweep.summary(sweep)))
        return GOOD
    with show.particles_drawn_beside(options) as beside:
        file, opened = cli_result.of_one_run(options.file, options.member, "show")
        with cli_result.shown(file), _voice("pictures are drawn"):
            if not options.only:
                _say(plots.summary(opened, shutil.get_terminal_size((0, 0)).columns))
            written = show.written(options, file, opened, beside)
    if written:
        _say("\n".join(["pictures:", *(f"  {path}" for path in written)]))
    if lacking := [name for name in dict.fromkeys(options.only) if name not in {path.stem for path in written}]:
        _say(f"this run has no picture {', '.join(lacking)}.")
    return GOOD


def _movie(options: Options) -> int:
    with Meter(_Console(highlight=False), "frames are drawn") as meter:
        message = movie.carry_out(options, meter)
    _say(message)
    return GOOD


def _tradeoff(options: Options) -> int:
    def tell(standing: "Standing") -> None:
        line = f"{standing.done} of {standing.settings} settings, {standing.spent:.0f} of {standing.budget:.0f} s"
        meter.show(standing.done / max(1, standing.settings), f"{line}: {standing.now}", f"{line}: {standing.now}")

    console = _Console(highlight=False)
    with interrupts.under_way(lambda by: KEPT), Meter(console, "looking for the exact answer") as meter:
        lines, interrupted = cli_tradeoff.carry_out(_load(options), options, tell)
    console.print(Text("\n".join(lines)), soft_wrap=True)
    if interrupted:
        _complain(KEPT)
        return INTERRUPTED
    return GOOD


def _verify(options: Options) -> int:
    kind: Any = hard if options.hard else cli_verify
    console = _Console(highlight=False)
    if not console.is_terminal:
        console = _Console(highlight=False, width=cli_verify.WIDTH)
    parts: list[Any] = []
    begun = time.monotonic()
    with interrupts.under_way(lambda by: "interrupted.", resumable=False):
        with _voice("importing") as voice:
            for part in kind.parts(options, voice.begin):
                parts.append(part)
                if not options.json:
                    console.print(kind.table(part, console.width))
        _say(kind.as_json(parts) if options.json else kind.total(parts, time.monotonic() - begun))
    return GOOD if all(part.holds for part in parts) else FAILED


def _completion(options: Options) -> int:
    _say(completion.script(parser_of(_commands(), _Version), options.shell))
    return GOOD


if __name__ == "__main__":
    sys.exit(main())
