"""The errors that the package raises on purpose; each carries one clear sentence for a person to read."""

from collections.abc import Mapping

SAID = "the first process of the run says the same"
"""A note of the error of another process, which is not to be said once more."""
_MOST_SHARES = 8  # of members, in one sentence


class AstroinertiaError(Exception):
    """Base of every error that the package raises on purpose."""


class SceneError(AstroinertiaError):
    """A scene, or an argument that stands for part of one, is wrong: what, where, and what would be right."""


class UnlistedError(SceneError, KeyError):
    """A table of the package does not have what is named; a KeyError, too."""

    __str__ = Exception.__str__  # that of a KeyError puts its sentence in quotation marks


class AbsentError(AstroinertiaError, AttributeError):
    """What is wanted of a body is not there, by its model or by what acts on it; why, in one clear sentence."""


class InstallationError(AstroinertiaError):
    """A package that this one stands on is missing, or of a version with which it does not work."""


class ArchiveError(AstroinertiaError):
    """A run directory, segment, checkpoint or dataset file cannot be read, written or continued."""


class NumericalError(AstroinertiaError):
    """A calculation left the numbers it can trust.

    effect: kind of the effect whose result is wrong, if one is to blame; time: of the state, in the units the caller
    works in, and their name where it has one; particle: identity of the first particle concerned.
    """

    def __init__(
        self,
        message: str,
        effect: str | None = None,
        time: float | None = None,
        particle: int | None = None,
        unit: str = "",
    ) -> None:
        self.message = message
        self.effect = effect
        self.time = time
        self.particle = particle
        self.unit = unit
        super().__init__(message, effect, time, particle, unit)  # all of them, so that the error survives pickling

    def __str__(self) -> str:
        parts = [
            None if self.effect is None else f"effect {self.effect}",
            None if self.time is None else f"time {self.time:.6g} {self.unit}".rstrip(),
            None if self.particle is None else f"particle {self.particle}",
        ]
        details = ", ".join(part for part in parts if part)
        return f"{self.message} ({details})" if details else self.message


class SceneWarning(UserWarning):
    """Something that a scene names is not taken as a whole; what is left out, in one clear sentence."""


class ArchiveWarning(UserWarning):
    """A file of a run folder is damaged; what stands in for it, or what is lost, in one clear sentence."""


class RunInterrupted(AstroinertiaError):
    """A run was stopped, by what `by` says; everything is saved, and `resume` on its folder goes on."""

    def __init__(self, folder: object, time: float, end: float, by: str = "request") -> None:
        self.folder = folder
        self.share = time / end
        self.by = by
        super().__init__(folder, time, end, by)

    def __str__(self) -> str:
        return f"the run was stopped by {self.by} at {100 * self.share:.1f}% and is saved in {self.folder}"


class CompanionInterrupted(RunInterrupted):
    """A run was stopped once it had ended, in the companion run `name` of its error bars; share: of that one."""

    def __init__(self, folder: object, name: str, number: int, runs: int, share: float, by: str = "request") -> None:
        self.name, self.number, self.runs = name, number, runs
        super().__init__(folder, share, 1.0, by)
        self.args = (folder, name, number, runs, share, by)

    def __str__(self) -> str:
        return (
            f"the run itself is done; what its error bars come from was stopped by {self.by} at "
            f"{100 * self.share:.1f}% of companion run {self.number} of {self.runs} ({self.name}), and is saved in "
            f"{self.folder}"
        )


class SweepInterrupted(RunInterrupted):
    """A sweep was stopped; under_way: the share that is done of each member that is saved by half, by its name."""

    def __init__(
        self, folder: object, done: int, members: int, by: str = "request", under_way: Mapping[str, float] | None = None
    ) -> None:
        self.done, self.members, self.under_way = done, members, dict(under_way or {})
        super().__init__(folder, done + sum(self.under_way.values()), members, by)
        self.args = (folder, done, members, by, self.under_way)

    def __str__(self) -> str:
        shares = [f"{name} at {100 * share:.1f}%" for name, share in self.under_way.items()]
        more = f" and {len(shares) - _MOST_SHARES} more" if len(shares) > _MOST_SHARES else ""
        under_way = f" and {', '.join(shares[:_MOST_SHARES])}{more}" if shares else ""
        return (
            f"the sweep was stopped by {self.by} with {self.done} of {self.members} members done{under_way}, and is "
            f"saved in {self.folder}"
        )
