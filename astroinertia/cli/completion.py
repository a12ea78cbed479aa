"""The command `completion`: what a shell needs to complete commands, options and files. Printing is left to main.py."""

import argparse
from pathlib import Path

from astroinertia.cli.parser import Add
from astroinertia.guide.pages import TOPICS
from astroinertia.storage.data_tables import scenes

HELP = """\
Once for each user; shells that are started from then on complete what is begun when Tab is pressed. The folder must
be there. Bash needs its package bash-completion, and zsh a compinit in ~/.zshrc and a folder of $fpath that you may
write to.

example: astroinertia completion bash > ~/.local/share/bash-completion/completions/astroinertia
         astroinertia completion zsh > "${fpath[1]}/_astroinertia"
         astroinertia completion fish > ~/.config/fish/completions/astroinertia.fish
"""


def add_arguments(add: Add) -> None:
    """Add the shell."""
    add("shell", metavar="SHELL", choices=("bash", "zsh", "fish"), help="bash, zsh or fish")


def script(parser: argparse.ArgumentParser, shell: str) -> str:
    """The script for a shell, with files for every path; changes the parser."""
    import shtab

    from astroinertia.bodies.planets import solar_system  # only here: completion needs the table
    from astroinertia.interop.export import FORMATS

    (listed,) = (action for action in parser._actions if isinstance(action, argparse._SubParsersAction))
    values = {
        "topic": tuple(TOPICS), "ready_made": tuple(scenes()), "to": FORMATS, "body": tuple(solar_system()),
    }  # fmt: skip
    for action in (action for command in listed.choices.values() for action in command._actions):
        if action.type is Path:
            action.complete = shtab.FILE
        elif action.dest in values:
            action.choices = values[action.dest]
    return shtab.complete(parser, shell)
