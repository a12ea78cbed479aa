"""Runs beside each other: differences, order, labels, the table, the picture and the command."""

import json

import numpy as np
import pytest

from astroinertia.cli.main import main
from astroinertia.plots import ladder
from tests.unit.affine_body import METADATA, affine_run
from tests.unit.affine_datasets import headline
from tests.unit.plots.test_plots import assert_legible
from tests.unit.rigid_body import RIGID, rigid_run


@pytest.fixture(scope="module")
def fine():
    return headline(affine_run()[0])


@pytest.fixture(scope="module")
def particles():
    """The same run as if by particles, 1 % larger, and seen less often."""
    records = [{**each, "inertia_tensor": 1.01 * each["inertia_tensor"]} for each in affine_run()[0][::2]]
    scene = 'name = "affine star"\n[body]\nkind = "uniform"\nparticles = 5000\n'
    return headline(records, {**METADATA, "model": "sph", "scene": scene, "body_particles": [5000]})


def quantity(found, name):
    (one,) = (each for each in found if each.name == name)
    return one


def test_differences_are_from_the_finest_at_the_times_of_each(fine, particles):
    """The particles are the finest: I of the other, at its own times, is 1/1.01 of it but for the spline."""
    found = ladder.compared([fine, particles])
    one = quantity(found, "moment_of_inertia")
    assert not one.lines[1].difference.any()
    assert len(one.lines[0].times) == fine.sizes["time"]
    direct = fine.inertia.about_axis("spin").values
    bounce = int(np.argmax(fine["density_max"].values))
    smooth = abs(np.arange(len(direct)) - bounce) > 20  # elsewhere, 61 outputs do not follow the bounce
    np.testing.assert_allclose(one.lines[0].difference[smooth], -0.01 * direct[smooth], rtol=0.02)
    assert one.size == pytest.approx(1.01 * direct.max())
    # the other way round, the times are those of the particles
    other = quantity(ladder.compared([fine, particles], finest=0), "moment_of_inertia")
    np.testing.assert_allclose(other.lines[1].difference, 0.01 * direct[::2], rtol=1e-12)


def test_beyond_the_times_of_the_finest_nothing_is_said(fine, particles):
    short = particles.isel(time=slice(0, 20))
    line = quantity(ladder.compared([fine, short]), "mean_radius").lines[0]
    beyond = line.times > float(short["time"][-1])
    assert beyond.any() and np.isnan(line.difference[beyond]).all() and np.isfinite(line.difference[~beyond]).all()


def test_runs_of_unlike_length_are_compared_as_far_as_both_go(fine, particles):
    """Also where the longer one has a single output within the shorter: then at the times of that one."""
    short = fine.isel(time=slice(0, 20))
    seldom = particles.isel(time=slice(0, None, 50))
    assert float(seldom["time"][1]) > float(short["time"][-1])
    for runs, finest in (([short, seldom], 0), ([short, seldom], 1), ([fine, particles.isel(time=slice(0, 10))], 1)):
        found = ladder.compared(runs, ["mean_radius"], finest)
        line = found[0].lines[1 - finest]
        end = min(float(run["time"][-1]) for run in runs)
        compared = line.at[np.isfinite(line.difference)]
        assert len(compared) >= 10 and compared[-1] <= end * (1 + 1e-12)
        figure = ladder.ladder_figure(runs, found, finest)
        left, right = figure.axes
        assert left.get_xlim()[1] / right.get_xlim()[1] == pytest.approx(
            max(float(run["time"][-1]) for run in runs) / compared[-1]
        )
        assert right.lines and "as far as both runs go" in right.get_xlabel()
        text = ladder.ladder_table(runs, found, finest)
        assert text.splitlines()[-1].endswith("over its largest value, as far as both runs go")
    alike = ladder.ladder_table([fine, particles], ladder.compared([fine, particles]), 1)
    assert "as far as" not in alike


def test_models_are_in_order_and_have_labels(fine, particles):
    scaling = headline(affine_run()[0][::4], {**METADATA, "model": "scaling"})
    more = particles.assign_attrs(body_particles="[20000]")
    runs = sorted([more, particles, fine, scaling], key=ladder.fineness)
    assert ladder.labels(runs) == ["scaling", "ellipsoid", "sph, 5000 particles", "sph, 20000 particles"]
    named = [fine, fine.assign_attrs(name="another")]
    assert ladder.labels(named) == ["ellipsoid (affine star)", "ellipsoid (another)"]
    assert ladder.labels([fine, fine]) == ["ellipsoid [1]", "ellipsoid [2]"]


def test_a_label_has_a_name_once_where_the_folder_has_it_too(fine):
    runs = [fine.assign_attrs(name=name) for name in ("core", "core", "other")]
    for run, folder in zip(runs, ("core", "again", "other"), strict=True):
        run.encoding["source"] = f"/runs/{folder}/core.nc"
    assert ladder.labels(runs) == ["ellipsoid (core)", "ellipsoid (core) (again)", "ellipsoid (other)"]


def test_runs_of_one_scene_are_named_by_the_settings_that_differ(fine):
    runs = []
    for number, period in enumerate(("2.0 s", "3.16227766016838 s")):
        settings = ['time.end="1 s"', f'body.rotation.period="{period}"']
        runs.append(fine.assign_attrs(overrides=json.dumps(settings)))
        runs[-1].encoding["source"] = f"/runs/sweep/member-{number:04d}/star.nc"
    assert ladder.labels(runs) == [
        "ellipsoid (period = 2 s)", "ellipsoid (period = 3.16228 s)",
    ]  # fmt: skip
    many = [run.assign_attrs(overrides=json.dumps([f"body.mass={k:060d}"])) for k, run in enumerate(runs)]
    assert ladder.labels(many) == ["ellipsoid (member-0000)", "ellipsoid (member-0001)"]


def test_long_labels_stay_within_the_picture(fine):
    mass = [f"{number:.14f} kg" for number in (1.2, 2.3, 3.4, 4.5, 5.6, 6.7, 7.8)]
    runs = [
        fine.assign_attrs(overrides=json.dumps([f'body.mass="{one}"', f'bodies.0.mass="{one}"', f"body.index={k}.5"]))
        for k, one in enumerate(mass)
    ]
    figure = ladder.ladder_figure(runs, ladder.compared(runs, ["mean_radius"]), 0)
    assert "(body.mass = 1.2 kg, bodies.0.mass = 1.2 kg, index = 0.5)" in ladder.labels(runs)[0]
    assert_legible(figure)


def test_files_of_one_folder_are_named_by_themselves(fine):
    runs = [fine.copy() for _ in range(3)]
    for run, file in zip(runs, ("a/coarse.nc", "a/fine.nc", "b/fine.nc"), strict=True):
        run.encoding["source"] = f"/from others/{file}"
    assert ladder.labels(runs[:2]) == ["ellipsoid (coarse)", "ellipsoid (fine)"]
    assert ladder.labels(runs) == ["ellipsoid (a) (coarse)", "ellipsoid (a) (fine)", "ellipsoid (b) (fine)"]


def test_round_off_is_neither_compared_nor_drawn_as_a_change(fine):
    noise = 2.2e-16 * np.resize([1.0, -1.0], fine.sizes["time"])
    shape, radius = fine.ellipsoid_flattening, fine.mean_radius
    runs = [
        fine.assign(ellipsoid_flattening=shape.copy(data=size), mean_radius=radius.copy(data=7.0 * (1.0 + size)))
        for size in (noise, 2.0 * noise)
    ]
    compared = ladder.compared(runs)
    assert "ellipsoid_flattening" not in [one.name for one in compared]
    figure = ladder.ladder_figure(runs, [quantity(compared, "mean_radius")], 1)
    assert figure.axes[0].get_ylim() == pytest.approx((6.93, 7.07))


def test_a_body_without_spin_has_no_share_of_rotational_energy_to_compare(fine):
    still = fine.assign(angular_momentum=0.0 * fine.angular_momentum)
    assert "rotational_to_gravitational" not in [one.name for one in ladder.compared([still, still])]


def test_what_one_model_lacks_is_reported_of_the_others(fine):
    rigid = headline(rigid_run()[::10], RIGID)
    found = ladder.compared([rigid, fine])
    assert "density_max" not in [one.name for one in found]  # the rigid body has none
    (one,) = ladder.compared([rigid, fine], ["angular_momentum"])
    sizes = np.linalg.norm(fine["angular_momentum"].transpose("time", "i").values, axis=1)
    np.testing.assert_allclose(one.lines[1].values, sizes)
    assert one.long_name.startswith("size of: ")


def test_what_cannot_be_compared_is_refused(fine, particles):
    code = headline(affine_run()[0][:5], {**METADATA, "dimensionless": True})
    for runs, names, words in (
        ([fine], (), "two to 7 runs"),
        ([fine] * 8, (), "two to 7 runs"),
        ([fine, code], (), "without dimension"),
        ([fine, particles], ["colour"], "quantity 'colour'"),
        ([fine, particles], ["kinetic_enrgy"], r"did you mean 'kinetic_energy'\?"),
        ([fine, particles], ["mean_angular_velocty"], r"did you mean 'mean_angular_velocity'\?"),
        ([fine, particles], ["principal_axes_of_nothing"], "no two of the runs"),
    ):
        with pytest.raises(ValueError, match=words):
            ladder.compared(runs, names)


@pytest.mark.full
def test_the_picture_is_legible_and_the_table_tells_the_numbers(fine, particles):
    runs = [fine, particles]
    found = ladder.compared(runs)
    assert_legible(ladder.ladder_figure(runs, found, 1))
    text = ladder.ladder_table(runs, found, 1)
    assert "nan" not in text
    assert max(map(len, text.splitlines())) <= 120
    lines = text.splitlines()
    after = lines[lines.index(next(line for line in lines if line.startswith("moment of inertia"))) :]
    cells = next(line for line in after if line.startswith("ellipsoid")).split()
    one = quantity(found, "moment_of_inertia")
    assert float(cells[-1]) == pytest.approx(abs(one.lines[0].difference).max() / one.size, rel=1e-2)
    assert "differences are from 'sph, 5000 particles'" in text


def test_the_table_fits_a_terminal_of_eighty_columns(fine, particles):
    runs = [fine, particles]
    found = ladder.compared(runs)
    narrow, wide = (ladder.ladder_table(runs, found, 1, columns).splitlines() for columns in (80, 0))
    assert max(map(len, narrow)) <= 80 < max(map(len, wide))
    assert " ".join(narrow).split() == " ".join(wide).split()  # the same words and numbers


def test_a_run_of_a_far_smaller_body_has_its_own_numbers_in_the_table(fine, particles):
    small = fine.assign(inertia_tensor=1e-30 * fine.inertia_tensor, mean_radius=1e-15 * fine.mean_radius)
    runs = [small, particles]
    text = ladder.ladder_table(runs, ladder.compared(runs, ["moment_of_inertia", "mean_radius"], finest=1), 1)
    _, *rows = [line.split()[1:5] for line in text.splitlines() if line.startswith("ellipsoid")]
    for row, series in zip(rows, (small.inertia.about_axis("spin"), small.mean_radius), strict=True):
        wanted = [series[0], series.min(), series.max(), series[-1]]
        assert [float(cell) for cell in row] == pytest.approx([float(each) for each in wanted], rel=1e-4)


def test_a_run_that_is_the_same_is_said_to_be(fine, particles):
    runs = [fine, fine.copy(deep=True), particles]
    text = ladder.ladder_table(runs, ladder.compared(runs, finest=0), 0)
    assert [line for line in text.splitlines() if "to the last bit" in line] == [
        "'ellipsoid [2]' is the same to the last bit"
    ]
    almost = runs[1].assign(mean_radius=runs[1]["mean_radius"] * (1 + 1e-15))
    assert "to the last bit" not in ladder.ladder_table([fine, almost], ladder.compared([fine, almost], finest=0), 0)


@pytest.mark.slow
def test_the_command(fine, particles, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    fine.to_netcdf("fine.nc", engine="netcdf4")
    particles.to_netcdf("particles.nc", engine="netcdf4")
    assert main(["compare", "particles.nc", "fine.nc", "--quantity", "mean_radius"]) == 0
    printed = capsys.readouterr().out
    assert "mean radius, equivalent ellipsoid (km)" in printed and "picture: compare.png" in printed
    assert printed.index("ellipsoid") < printed.index(
        "sph, 5000"
    )  # the cheaper first, in whatever order they are named
    assert (tmp_path / "compare.png").read_bytes()[:4] == b"\x89PNG"
    assert main(["compare", "particles.nc", "fine.nc", "--quantity", "mean_radius", "--against", "fine.nc"]) == 0
    assert "differences are from 'ellipsoid'" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["one.nc"], "does not exist"),
        (["one.nc", "two.nc", "--plot", "x.pdf"], "must be a .png file"),
        (["one.nc", "two.nc", "--against", "three.nc"], "none of the runs"),
        ([], "required"),
    ],
)
def test_what_the_command_refuses(arguments, words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["compare", *arguments]) == 2
    caught = capsys.readouterr()
    assert words in caught.err and caught.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []
