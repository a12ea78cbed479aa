"""A clock that only steps move: machines that test are shared."""

STEP = 10.0  # s


class Clock:
    """In the place of the module `time`. Its two readings differ, as those of a machine do."""

    now = 1000.0

    def monotonic(self):
        return self.now

    def time(self):
        return self.now + 1.7e9


def moved_by_steps(monkeypatch, body, modules):
    """The clock of these modules, under the name that they have for it; each step of a kind of body takes STEP."""
    clock, advance = Clock(), body.advance

    def slowly(*arguments):
        clock.now += STEP
        advance(*arguments)

    monkeypatch.setattr(body, "advance", slowly)
    for module in modules:
        monkeypatch.setattr(module, "clock" if hasattr(module, "clock") else "time", clock)
    return clock
