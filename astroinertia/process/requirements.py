"""Whether the packages that this one stands on are of versions that it works with, as its own metadata has them."""

from functools import cache

from astroinertia.errors import InstallationError


@cache
def check() -> None:
    """Look once at what is installed; InstallationError names the first package that is missing or of a wrong version.

    The one list is `dependencies` in pyproject.toml, which an installed package knows. A checkout that is imported
    without having been installed knows none, and is not checked. Tests: tests/unit/process/test_requirements.py.
    """
    from importlib.metadata import PackageNotFoundError, requires, version

    from packaging.requirements import Requirement

    try:
        listed = requires("astroinertia") or []
    except PackageNotFoundError:
        return
    for needed in map(Requirement, listed):
        if needed.marker is not None and not needed.marker.evaluate({"extra": ""}):
            continue
        wanted = f"{needed.name}{needed.specifier}"
        try:
            release = version(needed.name)
        except PackageNotFoundError:
            raise InstallationError(
                f"{needed.name} is not installed, and astroinertia needs it: pip install '{wanted}'."
            ) from None
        if not needed.specifier.contains(release, prereleases=True):
            raise InstallationError(
                f"{needed.name} {release} is installed, with which astroinertia does not work: pip install '{wanted}'."
            )
