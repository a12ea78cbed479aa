"""What users install and run: the wheel in an environment of its own, not the checkout that tests import."""

import pytest

from tests.installed.environment import ROOT, run, run_scenes, wheel, with_the_wheel

DATA = (
    "from importlib.resources import files; print(*sorted(each.name for each in files('astroinertia.data').iterdir()))"
)


@pytest.mark.slow
def test_each_model_runs_from_the_wheel_with_only_what_it_asks_for(tmp_path):
    elsewhere = tmp_path / "empty"
    elsewhere.mkdir()
    programs = with_the_wheel(wheel(tmp_path), tmp_path / "environment")
    (place,) = run([programs / "python", "-c", "import astroinertia; print(astroinertia.__file__)"], elsewhere).split()
    assert place.startswith(str(tmp_path / "environment"))
    missing = "import importlib.util as found; print(found.find_spec('pytest'), found.find_spec('dask'))"
    assert run([programs / "python", "-c", missing], elsewhere) == "None None\n"
    for name in run([programs / "python", "-c", DATA], elsewhere).split():
        assert (ROOT / "data" / name).exists()
    run_scenes(programs, elsewhere)
    assert "Mars" in run([programs / "astroinertia", "ratios", "--body", "Mars"], elsewhere)  # from a table of data/
    run([programs / "astroinertia", "new", "--from", "evrard", "cloud.toml"], elsewhere)
    evrard = (ROOT / "sims" / "evrard.toml").read_text()
    assert (elsewhere / "cloud.toml").read_text() == evrard.replace('name = "evrard"', 'name = "cloud"')
    assert "power law of exponent 1" in run([programs / "astroinertia", "plan", "cloud.toml"], elsewhere)
    for topic, words in (("ledger", "# The ledger"), ("scene", 'kind = "polytrope"'), ("effects", "## `gravity`")):
        assert words in run([programs / "astroinertia", "guide", topic], elsewhere)
