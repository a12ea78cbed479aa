"""Shells complete commands, options, files and topics of the guide with what `astroinertia completion` prints."""

import os
import pty
import shlex
import shutil
import subprocess
import time
from contextlib import suppress
from pathlib import Path

import pytest

from astroinertia.cli.main import main

LINES = {
    "pl": {"plan"},
    "run --max-w": {"--max-wall"},
    "plan oth": {"other.txt"},
    "plan sta": {"star.toml", "starry.toml"},
    "plan --set a=b oth": {"other.txt"},
    "run star.toml --output oth": {"other.txt"},
    "guide led": {"ledger"},
    "new --from evr": {"evrard"},
    "verify --mode in": {"individual"},
    "completion fi": {"fish"},
    "export star.toml --to v": {"vtk"},
    "ratios --body Ma": {"Mars"},
}


@pytest.fixture
def script(tmp_path, monkeypatch, capsys):
    """Writes the script of a shell into a folder `scripts` that lies beside files to complete."""
    monkeypatch.chdir(tmp_path)
    for name in ("star.toml", "starry.toml", "other.txt"):
        (tmp_path / name).touch()
    (tmp_path / "scripts").mkdir()

    def written(shell: str) -> Path:
        if shutil.which(shell) is None:
            pytest.skip(f"{shell} is not installed")
        assert main(["completion", shell]) == 0
        file = tmp_path / "scripts" / "_astroinertia"  # where zsh looks for it
        file.write_text(capsys.readouterr().out)
        return file

    return written


def lines(command: list[str]) -> list[str]:
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()


def test_bash_completes(script):
    tried = f"""source {script("bash")}
    offer=$(complete -p astroinertia | sed 's/.*-F *//; s/ .*//')
    COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); $offer; printf '%s\\n' "${{COMPREPLY[@]}}"
    """
    for line, offered in LINES.items():
        assert set(lines(["bash", "--norc", "-c", tried, "bash", "astroinertia", *line.split()])) == offered


def test_fish_completes(script):
    file = script("fish")
    for line, offered in LINES.items():
        shown = lines(
            ["fish", "--no-config", "-c", f"source {file}; complete -C {shlex.quote(f'astroinertia {line}')}"]
        )
        assert {each.partition("\t")[0] for each in shown} == offered


def wait_for(terminal: int, file: Path, count: int) -> None:
    """Wait until a file has so many lines; what the terminal shows is read, or the shell would wait for that."""
    until = time.monotonic() + 60.0
    while len(file.read_text().splitlines()) < count:
        assert time.monotonic() < until, file.read_text()
        with suppress(BlockingIOError):
            os.read(terminal, 1 << 16)
        time.sleep(0.02)


def test_zsh_completes(script, tmp_path):
    ran = tmp_path / "scripts" / "ran"
    ran.touch()
    begin = f"fpath=({script('zsh').parent} $fpath); autoload -Uz compinit; compinit -u -D\n"
    begin += f'astroinertia() {{ print -r -- "$@" >> {ran} }}; astroinertia ready\n'
    expected = ["ready"]
    mine, its = pty.openpty()
    os.set_blocking(mine, False)
    with subprocess.Popen(["zsh", "-f", "-i"], stdin=its, stdout=its, stderr=its, start_new_session=True) as shell:
        try:
            os.write(mine, begin.encode())
            wait_for(mine, ran, len(expected))
            for line, offered in LINES.items():
                if len(offered) == 1:
                    os.write(mine, f"astroinertia {line}\t\n".encode())
                    expected.append(" ".join([*line.split()[:-1], *offered]))
                    wait_for(mine, ran, len(expected))
        finally:
            shell.kill()
            os.close(mine)
            os.close(its)
    assert ran.read_text().splitlines() == expected


@pytest.mark.parametrize("arguments", [[], ["tcsh"]])
def test_another_shell_gets_one_sentence(arguments, capsys):
    assert main(["completion", *arguments]) == 2
    caught = capsys.readouterr()
    assert caught.out == "" and caught.err.startswith("astroinertia: ") and caught.err.count("\n") == 1
