"""Films: axes as the tensor has them, one scale of colours, whole files or none."""

import os
import subprocess
from pathlib import Path

import matplotlib
import numpy as np
import pytest
import xarray as xr
from PIL import Image

from astroinertia.cli.main import main
from astroinertia.errors import ArchiveError
from astroinertia.plots import film, matter as matter_module, movie, pictures
from astroinertia.plots.matter import POLE_ON, SIDE_ON, Matter, draw_triad, triads, triads_of_series
from astroinertia.plots.render import column_density
from tests.unit.affine_body import METADATA, affine_run, particle_sphere
from tests.unit.affine_datasets import headline, particles
from tests.unit.rigid_body import RIGID, rigid_run

AXES = np.array([1.0, 0.7, 0.4])


@pytest.fixture(scope="module")
def series():
    return headline(affine_run()[0][::10])


@pytest.fixture(scope="module")
def snapshots():
    return particles(affine_run()[1]).isel(particle=slice(0, None, 4))


def turned(angle):
    """A homogeneous ellipsoid with semi-axes AXES, turned about z."""
    points = particle_sphere(4000)
    points = np.concatenate([points, points * [-1, -1, 1], points * [-1, 1, -1], points * [1, -1, -1]]) * AXES
    c, s = np.cos(angle), np.sin(angle)
    count = len(points)
    matrix = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    places = points @ matrix.T + [0.5, 0.0, 0.0]
    return Matter(places, 0 * points, np.ones(count), np.full(count, 0.1), np.empty((0, 3)), np.full(3, np.inf))


def test_axes_of_particles_are_those_of_the_ellipsoid_and_follow_it_round():
    angles = np.linspace(0.0, 2.0 * np.pi, 25)
    found = triads(turned(angle) for angle in angles)
    longest = np.array([each.axes[0] for each in found])
    expected = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1) * np.sign(longest[0, 0])
    np.testing.assert_allclose(longest, expected, atol=1e-9)
    for each in found:
        np.testing.assert_allclose(each.lengths, AXES, rtol=0.02)
        np.testing.assert_allclose(each.centre, [0.5, 0.0, 0.0], atol=1e-12)
        assert each.defined.all()


def test_axes_are_drawn_as_they_are_seen():
    from matplotlib.figure import Figure

    (found,) = triads([turned(0.3)])
    for plane, seen in ((SIDE_ON, (np.cos(0.3), 0.0)), (POLE_ON, (np.cos(0.3), np.sin(0.3)))):
        panel = Figure().subplots()
        draw_triad(panel, found, plane, 2.0, 1.0)
        x, y = panel.lines[0].get_data()
        assert abs(np.array([x[1] - x[0], y[1] - y[0]])) == pytest.approx(found.lengths[0] * np.abs(seen), abs=1e-9)
        assert [x.mean(), y.mean()] == pytest.approx([0.25, 0.0], abs=1e-12)


def test_axes_of_a_rigid_body_are_fixed_in_it_though_moments_are_equal():
    moments = (0.2, 0.2, 0.35)
    dataset = headline(rigid_run(moments=moments, spin=(0.3, 0.0, 1.0), end=12.0, outputs=24), RIGID)
    found = triads_of_series(dataset, np.arange(0, 24, 5))
    squares = 5.0 * (0.5 * np.sum(moments) - np.array(moments))
    for each, number in zip(found, range(0, 24, 5), strict=True):
        np.testing.assert_allclose(each.axes, dataset["attitude"].values[number], atol=1e-12)
        np.testing.assert_allclose(each.lengths, np.sqrt(squares) * METADATA["code_units"]["length"], rtol=1e-9)
        assert np.all(each.defined)


def test_a_picture_of_condensed_matter_is_framed_between_core_and_envelope():
    """Half of the mass in a core of 0.01, the rest out to 1: neither is it 1.25 wide, nor 0.03."""
    uniform = particle_sphere(2000)
    condensed = np.concatenate([0.01 * uniform, uniform])
    free = np.empty((0, 3)), np.full(3, np.inf)  # without sinks and box
    sizes = np.repeat([0.01, 1.0], 2000)
    widths = [matter_module.reach(Matter(points, 0 * points, np.ones(len(points)), size, *free))
              for points, size in ((uniform, sizes[2000:]), (condensed, sizes))]  # fmt: skip
    assert widths[0] == pytest.approx(1.25, rel=0.02)
    assert 0.1 < widths[1] < 0.3


def test_a_picture_of_two_stars_shows_both_of_them_whole():
    uniform = particle_sphere(2000)
    star = uniform * np.linalg.norm(uniform, axis=1, keepdims=True) ** 2  # most of the mass in the inner third
    points = np.concatenate([star + [1.6, 0, 0], star - [1.6, 0, 0]])
    both = Matter(points, 0 * points, np.ones(len(points)), np.ones(len(points)), np.empty((0, 3)), np.full(3, np.inf))
    assert np.linalg.norm(points, axis=1).max() < matter_module.reach(both) < 3.0


def test_a_picture_of_a_planet_shows_the_small_one_that_strikes_it_whole():
    """An eighth of the mass, three radii away, as dense as the planet."""
    planet = particle_sphere(2000)
    points = np.concatenate([planet, 0.5 * planet[::7] + [3.0, 0.0, 0.0]])
    every = np.ones(len(points))
    both = Matter(points, 0 * points, every, 0.1 * every, np.empty((0, 3)), np.full(3, np.inf))
    assert 3.5 < matter_module.reach(both) < 4.5


def test_the_camera_stands_still_unless_the_body_changes_by_much():
    assert film.camera(np.array([1.0, 2.0, 3.9])).tolist() == [3.9, 3.9, 3.9]
    shrinking = np.geomspace(1.0, 0.01, 60)
    followed = film.camera(shrinking)
    assert followed[30] == pytest.approx(shrinking[30], rel=1e-9)
    assert (np.diff(np.log(followed)) < 0).all()


def test_at_most_so_many_outputs_are_filmed_from_the_first_to_the_last(series, snapshots):
    many = headline(rigid_run(outputs=600, end=1.0), RIGID)
    found = film.chosen(many, None)
    assert len(found) == film.MOST_FRAMES and found[0] == 0 and found[-1] == many.sizes["time"] - 1
    assert film.chosen(many, None, 3).tolist() == list(range(0, many.sizes["time"], 3))
    assert film.chosen(series, snapshots).tolist() == list(range(snapshots.sizes["snapshot_time"]))


def test_all_pictures_have_one_size_and_one_scale_of_colours(series, snapshots):
    """The same body with a tenth of the mass is darker: a scale of its own would hide it."""
    fainter = snapshots.isel(snapshot_time=[0, 1]).copy(deep=True)
    for name in ("position", "velocity", "density", "smoothing_length"):
        fainter[name][1] = fainter[name][0]
    fainter["mass"][1] = 0.1 * fainter["mass"][0]
    first, second = film.frames(series, fainter, np.array([0, 1]), 60)
    assert first.shape == second.shape == (408, 576, 3) and first.dtype == np.uint8
    middle = np.s_[100:200, 60:230]
    assert second[middle].mean() < 0.8 * first[middle].mean()
    # What does not move is the same, to the last dot: here the bar of colours.
    np.testing.assert_array_equal(first[30:260, 515:535], second[30:260, 515:535])


@pytest.mark.full
def test_a_picture_bears_no_traces_of_those_before_it(series):
    *_, after = film.frames(series, None, np.array([0, 3, 9]), 60)
    *_, alone = film.frames(series, None, np.array([6, 9]), 60)
    for part in (np.s_[:25], np.s_[290:]):  # the clock, and the strip with its marks
        np.testing.assert_array_equal(after[part], alone[part])


@pytest.mark.full
def test_the_header_is_the_name_of_the_run_in_plain_words(series):
    def header(name):
        (picture,) = film.frames(series.assign_attrs(name=name), None, np.array([0]), 60)
        return picture[:25, :420]

    np.testing.assert_array_equal(header("my_own_star"), header("my own star"))
    # What would be a formula is a name: this one would be refused, and signs of another would not be seen.
    assert (header("x $\\frac$") < 128).any()
    assert (header("$a$") < 128).any(axis=(0, 2)).sum() > (header("a a") < 128).any(axis=(0, 2)).sum()


def test_pictures_of_a_model_without_particles_show_its_ellipsoid(series):
    number = np.array([0])
    (picture,) = film.frames(series, None, number, 60)
    lit = picture[40:250, 60:270, 0].astype(int) - picture[40:250, 60:270, 2] > 15  # sand-coloured
    (found,) = triads_of_series(series, number)
    tall, wide = np.ptp(np.nonzero(lit.any(axis=1))[0]), np.ptp(np.nonzero(lit.any(axis=0))[0])
    shape = found.axes.T @ np.diag(found.lengths**2) @ found.axes
    assert tall / wide == pytest.approx(np.sqrt(shape[2, 2] / shape[0, 0]), rel=0.06)


def test_a_gif_holds_every_picture_at_its_rate(series, snapshots, tmp_path):
    assert movie.write_movie(series, snapshots, tmp_path / "film.gif", fps=10.0, every=4) == 4
    with Image.open(tmp_path / "film.gif") as opened:
        assert opened.n_frames == 4
        assert opened.info["duration"] == 100
    assert [path.name for path in tmp_path.iterdir()] == ["film.gif"]


def coder():
    return movie.ffmpeg() or pytest.skip("films in MP4 need ffmpeg or imageio-ffmpeg, which is an extra")


def test_gradients_of_a_gif_show_no_bands_and_a_small_bright_core_keeps_its_colour():
    across, up = np.meshgrid(np.linspace(-1, 1, 320), np.linspace(-1, 1, 240))
    share = np.log1p(100 / (0.01 + 300 * (across**2 + up**2))) / np.log1p(1e4)
    maps = [matplotlib.colormaps[name](share)[..., :3] for name in ("inferno", "viridis", "Blues")]
    picture = (255 * np.concatenate(maps)).round().astype(np.uint8)
    kept = np.asarray(movie._reduced(picture).convert("RGB"), dtype=float)
    seen = (kept - picture).reshape(-1, 4, 80, 4, 3).mean((1, 3))  # by eyes that do not tell neighbouring pixels apart
    assert np.sqrt((seen**2).mean()) < 1.5
    assert abs(seen).max() < 16


def test_an_mp4_shows_the_pictures(series, snapshots, tmp_path):
    program, path = coder(), tmp_path / "film.mp4"
    movie.write_movie(series, snapshots, path, every=12)
    decoded = subprocess.run(
        [program, "-loglevel", "error", "-i", path, "-f", "rawvideo", "-pix_fmt", "rgb24", "-"],
        capture_output=True, check=True,
    ).stdout  # fmt: skip
    numbers = film.chosen(series, snapshots, 12)
    pictures = list(film.frames(series, snapshots, numbers, 130))
    shown = np.frombuffer(decoded, np.uint8).reshape(len(numbers), *pictures[0].shape)
    for picture, seen in zip(pictures, shown, strict=True):
        assert abs(picture.astype(int) - seen).mean() < 4.0


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [".gif", ".mp4"])
def test_what_is_interrupted_leaves_no_file_and_the_film_of_before(suffix, series, snapshots, tmp_path):
    path = tmp_path / f"film{suffix}"
    if suffix == ".mp4":
        coder()
    before = b"GIF89a, before" if suffix == ".gif" else b"\0\0\0 ftypisom, before"
    path.write_bytes(before)

    def interrupt(done, count):
        assert count == 13
        if done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        movie.write_movie(series, snapshots, path, listener=interrupt)
    assert [each.name for each in tmp_path.iterdir()] == [path.name]
    assert path.read_bytes() == before


@pytest.mark.full
def test_an_ffmpeg_that_fails_is_quoted_and_leaves_nothing(series, snapshots, tmp_path, monkeypatch):
    broken = tmp_path / "bin" / "ffmpeg"
    broken.parent.mkdir()
    broken.write_text("#!/bin/sh\necho 'Unknown encoder' >&2\nexit 1\n")
    broken.chmod(0o755)
    monkeypatch.setenv("PATH", f"{broken.parent}{os.pathsep}{os.environ['PATH']}")
    with pytest.raises(ArchiveError, match="ffmpeg says: Unknown encoder"):
        movie.write_movie(series, snapshots, tmp_path / "film.mp4", every=6)
    assert [each.name for each in tmp_path.iterdir()] == ["bin"]


def test_without_ffmpeg_a_film_is_a_gif(series, snapshots, tmp_path, monkeypatch):
    monkeypatch.setattr(movie, "ffmpeg", lambda: None)
    with pytest.raises(ArchiveError, match="no ffmpeg"):
        movie.write_movie(series, snapshots, tmp_path / "film.mp4")
    with pytest.raises(ArchiveError, match=r"ends in \.mp4 or \.gif"):
        movie.write_movie(series, snapshots, tmp_path / "film.avi")


@pytest.mark.slow
def test_the_commands_write_beside_the_result(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(movie, "ffmpeg", lambda: None)
    monkeypatch.setattr(pictures, "FIGURES", {"shape": pictures.FIGURES["shape"]})
    headline(affine_run()[0][::40]).to_netcdf(tmp_path / "star.nc")
    for command, name in (("movie", "film.gif"), ("view", "view.html"), ("report", "report.html")):
        assert main([command, str(tmp_path / "star.nc")]) == 0
        assert capsys.readouterr().out.startswith(f"wrote {tmp_path / name}: ")
        assert (tmp_path / name).stat().st_size > 1000


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["movie", "star.nc", "--fps", "0"], "--fps must be"),
        (["movie", "star.nc", "--every", "0"], "--every must be"),
        (["movie", "star.nc", "--output", "film.avi"], "ends in .mp4 or .gif"),
        (["movie", "nothing.nc"], "does not exist"),
        (["view", "star.nc", "--output", "nowhere/view.html"], "cannot be written"),
    ],
)
def test_what_cannot_be_done_gets_one_sentence(arguments, words, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    headline(affine_run()[0][::40]).to_netcdf("star.nc")
    assert main(arguments) == 2
    printed = capsys.readouterr().err
    assert words in printed and printed.count("\n") == 1
    assert [each.name for each in tmp_path.iterdir()] == ["star.nc"]


@pytest.mark.parametrize(
    "name",
    [
        "-y.mp4",
        pytest.param("md5:x.mp4", marks=pytest.mark.full),
        pytest.param("tcp:127.0.0.1:9/film.mp4", marks=pytest.mark.full),
    ],
)
def test_a_path_is_neither_an_option_nor_an_address(tmp_path, monkeypatch, series, name):
    program = tmp_path / "ffmpeg"
    program.write_text(
        f'#!/bin/sh\nprintf "%s\\n" "$@" > "{tmp_path}/asked"\nfor last; do :; done\ncat > "${{last#file:}}"\n'
    )
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "tcp:127.0.0.1:9").mkdir()
    movie.write_movie(series.isel(time=slice(0, 2)), None, Path(name))
    asked = (tmp_path / "asked").read_text().splitlines()
    assert asked[-1].startswith(f"file:{tmp_path / name}.")
    assert asked[asked.index("-i") - 2 : asked.index("-i") + 2] == ["-protocol_whitelist", "pipe", "-i", "pipe:0"]
    assert (tmp_path / name).stat().st_size > 0


def test_a_time_is_shown_as_it_is(series):
    """With 0 and 1.5 one digit less would tell two frames apart, and say 2 of the second."""
    for times, shown in (
        ([0.0, 1.5], ["0.0", "1.5"]),
        ([0.0, 0.25, 0.5], ["0.00", "0.25", "0.50"]),
        ([0.0, 1 / 3, 2 / 3], ["0.00", "0.33", "0.67"]),
        ([0.0, 10.0, 20.0], ["0", "10", "20"]),
    ):
        factor = film.style.shown_times(series)[1]
        subject = film._Subject(np.array(times) * factor, np.ones(len(times)), "m", lambda *_: None)
        assert film._clock(subject, series)[0] == shown


def test_matter_of_a_box_that_repeats_itself_fills_its_picture(series, snapshots):
    """Streams that have left through a face come in by the other one, and nothing is seen of the faces."""
    places = np.stack(np.meshgrid(*[(np.arange(8) + 0.5) / 8 - 0.5] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    left = places + [3.0, 0.0, 0.25]  # what has gone round three times
    one_each = {"mass": 1.0, "density": 1.0, "smoothing_length": 0.16}
    one = xr.Dataset(
        {name: ("particle", np.full(512, value)) for name, value in one_each.items()}
        | dict.fromkeys(("position", "velocity"), (("particle", "i"), left)),
        attrs={"box": [1.0, 1.0, 1.0]},
    )
    found = matter_module.matter(one)
    assert matter_module.reach(found) == 0.5 and abs(found.position).max() <= 0.5
    seen = found.repeated((0, 1))
    image = column_density(seen.position, seen.mass, seen.size, (0, 1), 0.5, 32)
    assert image.max() < 1.02 * image.min() and image.mean() == pytest.approx(512.0, rel=0.02)
    assert len(found.repeated((0,)).mass) == 512 + 2 * 3 * 64  # three layers beyond each face
    whole = matter_module.completed(series.assign_attrs(box="[1.0, null, 2.0]"), snapshots).attrs["box"]
    assert whole == [1.0, np.inf, 2.0]
