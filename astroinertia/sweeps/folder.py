"""The folder of a sweep: what is to be run, and how far each member is.

    sweep.json            the scene and all members, written once
    session               a text that names the process that runs members now; they stop where it is another
    member-0000/ ...      an ordinary run folder each, with failure.json where it failed
    <name>.nc             the result, once all members are finished or have failed
    lock                  held by the one process that gives out members

Tests: tests/unit/sweeps/test_ensemble.py.
"""

import itertools
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from astroinertia.errors import ArchiveError, SceneError
from astroinertia.scene.scales import code_units
from astroinertia.scene.sweep import GRID, Sweep, member
from astroinertia.scene.sweep_values import MOST_MEMBERS, coordinate
from astroinertia.storage import trailer
from astroinertia.storage.archive import MANIFEST, SWEEP, Archive, refuse_if_taken
from astroinertia.storage.atomic import made_folder, own_folder, read_json, write_json
from astroinertia.storage.bounded import plain_text
from astroinertia.storage.manifest import FAILURE

FORMAT, VERSION = "astroinertia-sweep", 1
SESSION = "session"


@dataclass(frozen=True)
class Failure:
    """Why a member has no result; lasting: it would fail in the same way again, so it is not run again."""

    sentence: str
    lasting: bool


def describe(sweep: Sweep, folder: Path) -> None:
    """Make the folder of a new sweep, or see that it holds this one; ArchiveError if it holds something else.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     describe(read(Path("runs/sweep")), Path(folder))
    ...     print(read(Path(folder)).members)
    ((1.5,), (3.0,))
    """
    refuse_others(sweep, folder)
    made_folder(folder)
    if not (folder / SWEEP).exists():
        write_json(folder / SWEEP, {"format": FORMAT, "version": VERSION, **_plain(sweep)})


def refuse_others(sweep: Sweep, folder: Path) -> None:
    """ArchiveError for a folder that holds something else than this sweep; it may not be there.

    >>> refuse_others(read(Path("runs/sweep")), Path("runs/sweep"))
    """
    if not (folder / SWEEP).exists():
        refuse_if_taken(folder, {"name": sweep.name})
    elif read(folder) != sweep:
        raise ArchiveError(f"{folder} already holds another sweep, or members of other values; choose another folder.")


def read(folder: Path) -> Sweep:
    """The sweep that a folder holds; ArchiveError if there is none, or it cannot be read.

    >>> print(read(Path("runs/sweep")).keys, read(Path("runs/sweep")).members)
    ('body.index',) ((1.5,), (3.0,))
    """
    path = folder / SWEEP
    try:
        content = read_json(path)
    except (FileNotFoundError, NotADirectoryError):
        raise ArchiveError(f"{folder} holds no sweep (it has no {SWEEP}).") from None
    if not isinstance(content, dict) or content.pop("format", None) != FORMAT:
        raise ArchiveError(f"{path} does not describe a sweep of this package.")
    version = content.pop("version", 0)
    if not isinstance(version, int) or version > VERSION:
        raise ArchiveError(f"{path} has format {version!r:.20} of a newer version; this one reads up to {VERSION}.")
    try:
        content |= {name: tuple(content[name]) for name in ("overrides", "keys")}
        content |= {name: tuple(tuple(values) for values in content[name]) for name in ("members", "axes")}
        sweep = Sweep(**content, file=str(path))
        _check(sweep)
    except (KeyError, TypeError, ValueError, SceneError) as error:
        raise ArchiveError(f"{path} is damaged: {plain_text(error).rstrip('.')}.") from None
    return sweep


def _check(sweep: Sweep) -> None:
    """ValueError for what no sweep is, whoever wrote it; what is set in members, their scenes are asked when made."""
    texts = (sweep.name, sweep.kind, sweep.text, sweep.source, *sweep.overrides, *sweep.keys)
    if not all(isinstance(text, str) for text in texts) or not isinstance(sweep.origin, str | None):
        raise ValueError("its texts are none")
    if not 1 <= len(sweep.members) <= MOST_MEMBERS or not sweep.keys:
        raise ValueError(f"it has {len(sweep.members)} members of {len(sweep.keys)} parameters")
    if any(len(values) != len(sweep.keys) for values in sweep.members):
        raise ValueError("a member has more or fewer values than there are parameters")
    if sweep.kind == GRID and tuple(itertools.product(*sweep.axes)) != sweep.members:
        raise ValueError("its members are not those of its grid")
    for number in range(len(sweep.keys)):
        coordinate([values[number] for values in sweep.members])


def place(folder: Path, number: int) -> Path:
    """The folder of a member; ArchiveError where it is a link, which may lead anywhere.

    >>> print(place(Path("runs/sweep"), 3))
    runs/sweep/member-0003
    """
    return own_folder(folder, member(number))


def _plain(sweep: Sweep) -> dict[str, Any]:
    content = asdict(sweep)
    del content["file"], content["own"]
    return content


def finished(folder: Path, number: int) -> Path | None:
    """The netCDF file of a member that is finished; None where it is damaged, too, so that it is written again.

    >>> print(finished(Path("runs/sweep"), 0).parent.name, finished(Path("runs/sweep"), 7))
    member-0000 None
    """
    own = place(folder, number)
    if not (own / MANIFEST).exists():
        return None
    try:
        file = Archive.view(own).finished
        return file if file is not None and trailer.is_whole(file) else None
    except ArchiveError:
        return None  # damaged: to be reported when the member is gone on with


def under_way(sweep: Sweep, folder: Path) -> dict[str, float]:
    """The share of its time that is saved of each member which is begun and neither finished nor failed, by its name.

    >>> print(under_way(read(Path("runs/sweep")), Path("runs/sweep")))
    {}
    """
    shares = {}
    for number in range(len(sweep.members)):
        own = place(folder, number)
        if not (own / MANIFEST).exists() or finished(folder, number) or failure(folder, number):
            continue
        with suppress(ArchiveError, OSError):  # damaged: to be reported when the member is gone on with
            arrays, _ = Archive.view(own).read_checkpoint() or ({"time": 0.0}, {})
            scene = sweep.scene(number)
            time = code_units(scene).to_si(arrays["time" if "time" in arrays else ".time"], "time")
            shares[member(number)] = float(time) / scene.time.end
    return shares


def failure(folder: Path, number: int) -> Failure | None:
    """Why a member failed when it was last run, if it did.

    >>> print(failure(Path("runs/sweep"), 0))
    None
    """
    try:
        noted = Failure(**read_json(place(folder, number) / FAILURE))
    except (OSError, ArchiveError, TypeError):
        return None
    return noted if isinstance(noted.sentence, str) and isinstance(noted.lasting, bool) else None


def note_failure(own: Path, why: Failure) -> None:
    """Keep why the member in the folder `own` failed.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     note_failure(Path(folder, member(3)), Failure("the body sheds mass", lasting=True))
    ...     print(failure(Path(folder), 3).sentence, waiting(Path(folder), 5))
    the body sheds mass [0, 1, 2, 4]
    """
    own_folder(own.parent, own.name).mkdir(parents=True, exist_ok=True)
    write_json(own / FAILURE, asdict(why))


def waiting(folder: Path, count: int) -> list[int]:
    """Numbers of the members that are to be run, or run again.

    >>> print(waiting(Path("runs/sweep"), 4))
    [2, 3]
    """
    left = [number for number in range(count) if finished(folder, number) is None]
    return [number for number in left if not ((noted := failure(folder, number)) and noted.lasting)]
