"""The parser of arguments: what its help says, and what commands take. Printing is left to main.py."""

import argparse
import difflib
import re
import shlex
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple, NoReturn

from astroinertia.errors import SceneError

DESCRIPTION = (
    "Evolves rotating, self-gravitating fluid bodies and follows their inertia tensor through its own equation."
)
EXAMPLES = """\
a first session:
  astroinertia new star.toml                 write a commented scene, to edit
  astroinertia plan star.toml                see what would be run, and why
  astroinertia run star.toml                 run it; the result is runs/<name>/<name>.nc
  astroinertia show runs/<name>              a summary, and pictures beside the file
  astroinertia guide                         the guide: its topics; astroinertia guide first-run to begin

more:
  astroinertia new --from evrard cloud.toml  a scene that runs as it stands; `astroinertia new --help` lists them
  astroinertia run star.toml --set body.particles=5000 --set "time.end=2 s" --output runs/coarse
  astroinertia movie runs/<name>             a film of the body; report and view: pages for a browser
  astroinertia compare runs/coarse runs/fine  the same quantities of several runs or models, and how far they differ
  astroinertia tradeoff star.toml            what accuracy costs: errors and times, knob by knob
  astroinertia moments particles.csv         the inertia tensor of a particle table, a mesh or a snapshot
  astroinertia export runs/coarse --to vtk   for other programs: GADGET, SWIFT, ParaView, CSV, Zarr
  astroinertia ratios --body Mars            moment ratios of the solar system, and cores that they allow
  astroinertia precession --body Saturn      how fast an axis precesses, and by which companion
  astroinertia verify                        every cross-check with its source: does this installation compute right?
  astroinertia calibrate                     measure this machine, so that plans predict how long runs take
  astroinertia verify --hard                 eighty hard cases of particles, and what stable means for each
  astroinertia run grid.toml --workers 4     a scene with [sweep]: many runs, and one dataset of all
  astroinertia resume runs/coarse            continue after Ctrl-C, a crash or a power cut
  astroinertia resume runs/coarse --set "time.end=4 s"  to a later end than it was to have
  astroinertia branch runs/coarse --at "1 s" --set ...  another run from a state of this one, with other effects
  astroinertia completion bash               what a shell needs to complete commands with the Tab key
  python -c "import xarray; print(xarray.open_dataset('runs/coarse/<name>.nc'))"
"""


Add = Callable[..., object]  # ArgumentParser.add_argument of one command
Options = argparse.Namespace  # what a command got
Say = Callable[[str], None]  # prints a line


class Command(NamedTuple):
    """A command: the function that it is, what it does in words, the end of its help, and what adds its arguments.

    help: lines that end with examples, or what follows `astroinertia NAME` in the only example.
    """

    action: Callable[[Options], int]
    text: str
    help: str
    arguments: tuple[Callable[[Add], None], ...] = ()


class _Help(argparse.HelpFormatter):
    """Leaves text of several lines as it is, and breaks that of one."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        return text if "\n" in text else super()._fill_text(text, width, indent)


class _Parser(argparse.ArgumentParser):
    """Says what is wrong with the arguments in one sentence, and takes no part of an option's name for the whole."""

    def __init__(self, **settings) -> None:
        super().__init__(**settings, formatter_class=_Help, allow_abbrev=False)
        self._negative_number_matcher = re.compile(r"-\.?\d")  # argparse's takes -1e-5 and -5km for options
        self.register("type", Path, _path)

    def parse_known_args(self, args=None, namespace=None):
        """As argparse's, but each command refuses what it does not know by itself, with the option that was meant."""
        found, unknown = super().parse_known_args(args, namespace)
        if unknown:
            letters = unknown[0].partition("=")[0].lstrip("-")
            names = [name for name in self._option_string_actions if name.startswith("--")]
            begun = [name for name in names if letters and name[2:].startswith(letters)]
            meant = begun or difflib.get_close_matches(unknown[0][:64], names, n=1, cutoff=0.6)
            if not unknown[0].startswith("-"):
                named = "--body" in names and found.body is None  # as a command takes it that is about no file
                meant = [f"--body {shlex.quote(unknown[0])}"] if named else []
            hint = f" (did you mean {meant[0]}?)" if meant else ""
            self.error(f"unrecognized arguments: {' '.join(unknown)}{hint}")
        return found, unknown

    def error(self, message: str) -> NoReturn:
        raise SceneError(f"{message}; `{self.prog} --help` says more.")


def _path(text: str) -> Path:
    if not text:  # as of a variable of the shell that is not set: the folder in which one is would be taken
        raise argparse.ArgumentTypeError("the path is empty")
    return Path(text)


def parser_of(commands: Mapping[str, Command], version: type[argparse.Action]) -> argparse.ArgumentParser:
    """The parser of all commands; what it finds has the function of the command as `command`."""
    parser = _Parser(prog="astroinertia", description=DESCRIPTION, epilog=EXAMPLES)
    parser.add_argument("-V", "--version", action=version, nargs=0, help="its version, and those of the packages used")
    listed = parser.add_subparsers(metavar="COMMAND", required=True)
    for name, (action, text, end, arguments) in commands.items():
        epilog = end if "\n" in end else f"example: astroinertia {name} {end}"
        command = listed.add_parser(name, help=text, description=f"{text[:1].upper()}{text[1:]}.", epilog=epilog)
        command.set_defaults(command=action)
        for add_arguments in arguments:
            add_arguments(command.add_argument)
    return parser


def add_scene(add: Add) -> None:
    """Add the scene that a command is about, and changes of its keys."""
    add("scene", metavar="SCENE", type=Path, help="scene file (TOML)")
    add_settings(add, 'set a key of the scene, such as body.particles=5000 or "time.end=2 s"; may be repeated')


def add_settings(add: Add, text: str) -> None:
    """Add changes of a scene's keys, and what they are for."""
    add("--set", dest="overrides", action="append", default=[], metavar="KEY=VALUE",
        help=text)  # fmt: skip
