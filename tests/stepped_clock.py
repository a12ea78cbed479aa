"""A clock that only steps move: machines that test are shared."""

from astroinertia.run import loop

STEP = 10.0  # s


class Clock:
    """In the place of the module `time`. Its two readings differ, as those of a machine do."""

    now = 1000.0

    def monotonic(self):
        return self.now

    def time(self):
        return self.now + 1.7e9


def moved_by_steps(monkeypatch, body, modules):
    """The clock of these modules, under the name that they have for it; each step of a kind of body takes STEP.

    A body that can go through many outputs in one call goes to one in each.
    """
    clock = Clock()

    def slowly(name):
        method = getattr(body, name)

        def call(*arguments):
            clock.now += STEP
            return method(*arguments)

        monkeypatch.setattr(body, name, call)

    for name in ("advance", "through"):
        if hasattr(body, name):
            slowly(name)
    monkeypatch.setattr(loop, "OUTPUTS_AT_ONCE", 1)
    for module in modules:
        monkeypatch.setattr(module, "clock" if hasattr(module, "clock") else "time", clock)
    return clock
