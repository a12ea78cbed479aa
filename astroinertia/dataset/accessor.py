"""`dataset.inertia`: derived quantities and plots on any dataset of this package, however it was opened.

The package registers the accessor for xarray's Dataset and DataTree when both are imported.
"""

import difflib
import html
import inspect
from typing import Any

import numpy as np
import xarray as xr

from astroinertia.dataset import arranged, open_snapshots, principal
from astroinertia.dataset.absent import reasons, whole
from astroinertia.dataset.arranged import in_seconds, with_labels
from astroinertia.dataset.by_member import (
    begun,
    earliest,
    must_be_of_one_run,
    must_have_times,
    of_each_member,
    reached,
    source_of,
    swept,
)
from astroinertia.dataset.derived import SPINLESS
from astroinertia.dataset.gravity_field import field_labels, field_variables, run_fields
from astroinertia.dataset.picture_methods import picture
from astroinertia.dataset.principal import Axis, axis_text, directions
from astroinertia.dataset.schema import INERTIAL
from astroinertia.errors import AbsentError, ArchiveError, SceneError
from astroinertia.inertia import growth, tensor
from astroinertia.inertia.evolution import gravitational_wave_strain, second_moment_acceleration
from astroinertia.inertia.spin import angular_velocity
from astroinertia.process.positive import require_positive
from astroinertia.process.quantities import InputError, with_quantities
from astroinertia.units import astropy_quantity, in_si, quantity as quantity_of, shown, unit_of, with_unit

_TURNED = 0.1  # radians that an axis may turn and be said to stay
_NO_MODE = 1e-14  # of the whole mass: an amplitude that sums over a body round to where it has no such mode
_THINNEST = 1e-12  # I_1 + I_2 - I_3 over I_3, which is the square of a thickness: round-off
MOTION = "motion"  # the share that is not an effect's: the kinetic tensor's


class InertiaAccessor:
    """The inertia tensor of a dataset and what follows from it; every result keeps coordinates, units and meaning.

    On the dataset of a sweep, results have the sweep's dimensions in front; pictures are of one member.

    In the examples, ds is the dataset of a star out of balance that begins to fall together.

    >>> one = ds.inertia
    >>> figures = [one.plot_inertia(), one.plot_spin(), one.plot_attitude(), one.plot_ledger(), one.plot_shape()]
    >>> figures += [one.plot_energy(), one.plot_error_bars(), one.plot_waves(), one.plot_density(), one.plot_profiles()]
    >>> print(len(figures))
    10
    """

    def __init__(self, opened: xr.Dataset | xr.DataTree) -> None:
        arranged.require_tensor(opened)
        self._tree = opened if isinstance(opened, xr.DataTree) else None
        dataset = opened.to_dataset() if isinstance(opened, xr.DataTree) else opened
        dataset = arranged.from_x_to_z(whole(arranged.along(in_seconds(dataset))))
        arranged.require_own_units(dataset)
        arranged.require_room(dataset)
        self.dataset = dataset if swept(dataset) or "mass" not in dataset else reached(dataset)

    def __repr__(self) -> str:
        width = max(len(name) for name, _ in self._parts())
        lines = [f"  .{name:<{width}}  {text}" for name, text in self._parts()]
        return "\n".join([f"{self._title()}, and what follows from it:", *lines])

    def _repr_html_(self) -> str:
        rows = (
            f"<tr><td><code>.{html.escape(name)}</code></td><td style='text-align: left'>{html.escape(text)}</td></tr>"
            for name, text in self._parts()
        )
        return f"<p>{html.escape(self._title())}, and what follows from it:</p><table>{''.join(rows)}</table>"

    def _title(self) -> str:
        attrs = self.dataset.attrs
        return f"The inertia tensor of {attrs.get('name', 'a body')} (model {attrs.get('model', 'unknown')})"

    @classmethod
    def _parts(cls) -> list[tuple[str, str]]:
        """What it can do, each with the first sentence of what is said of it."""
        parts = []
        for name, part in vars(cls).items():
            if not name.startswith("_"):
                text = inspect.getdoc(part) or ""
                brackets = "" if isinstance(part, property) else "()"
                parts.append((f"{name}{brackets}", text.split("\n")[0]))
        return parts

    @property
    def absent(self) -> dict[str, str]:
        """The quantities that this run does not have, each with the reason: they are NaN in its file.

        >>> print(ds.inertia.absent["attitude"])
        only a rigid body has axes of its own
        """
        return reasons(self.dataset)

    @property
    @of_each_member
    def principal(self) -> xr.Dataset:
        """Principal moments, axes and gaps, and the rate at which the axes turn, but of a tensor given since.

        >>> moments, tensor = ds.inertia.principal.principal_moments[0], ds.inertia_tensor[0]
        >>> print(f"{float(moments.sum() / np.trace(tensor)):.6f}")  # the trace is the same in all axes
        1.000000
        """
        names = self._must_have(*principal.NAMES)
        return principal.of_its_tensor(self.dataset[names], self._named("inertia_tensor"))

    @property
    def snapshots(self) -> xr.Dataset | None:
        """The particles of the snapshots; None if there are none or the dataset's file is not known.

        >>> print(ds.inertia.snapshots.sizes["particle"])
        100
        """
        if self._tree is not None:
            return self._tree["snapshots"].to_dataset() if "snapshots" in self._tree.children else None
        try:
            source = source_of(self.dataset)
            return None if source is None else open_snapshots(source, chunks={} if self.dataset.chunks else None)
        except (ArchiveError, OSError):
            return None

    def quantity(self, series: str | xr.DataArray) -> Any:
        """A variable of the dataset by its name, or a result of this accessor, as an astropy Quantity.

        >>> print(f"{ds.inertia.quantity('mass')[0].to('Msun'):.3f}")
        1.000 solMass
        """
        values = self._named(series)
        if values.dtype.kind not in "fiub":
            raise InputError(f"{values.name} has no numbers, so that it has no unit.")
        return astropy_quantity(values.values, unit_of(values))

    @with_quantities()
    @of_each_member
    def about_axis(self, axis: Axis = "z") -> xr.DataArray:
        """Moment of inertia n.I.n about an axis: "x", "y", "z", a vector (3,), or one for each time, (time, i).

        >>> print(bool((ds.inertia.about_axis([0, 0, 2]) == ds.inertia_tensor.sel(i="z", j="z")).all()))  # n.I.n
        True
        """
        inertia = self._named("inertia_tensor")
        direction = self._axis(axis)
        moment = tensor.moment_about(inertia.transpose("time", "i", "j").values, direction)
        return self._series(moment, f"moment of inertia about {axis_text(axis)}", unit_of(inertia), "n.I.n")

    @with_quantities()
    @of_each_member
    def radius_of_gyration(self, axis: Axis = "z") -> xr.DataArray:
        """sqrt(n.I.n / M) about an axis.

        >>> print(f"{float(ds.inertia.radius_of_gyration()[0]) / 6.957e8:.2f}")  # solar radii; the limit is 0.45
        0.43
        """
        radius = np.sqrt(self.about_axis(axis).values / self._named("mass").values)
        return self._series(radius, f"radius of gyration about {axis_text(axis)}", self._unit("m"), "sqrt(n.I.n / M)")

    @with_quantities()
    @of_each_member
    def moment_ratio(self, radius: float | xr.DataArray, axis: Axis = "spin") -> xr.DataArray:
        """n.I.n / (M R^2) for a positive radius of the reader's choice, in the dataset's unit of length.

        >>> print(f"{float(ds.inertia.moment_ratio(6.957e8)[0]):.2f}")  # 0.2046 of the n = 3/2 polytrope, in the limit
        0.18
        """
        if isinstance(radius, xr.DataArray):
            radius = with_labels(in_seconds(radius), "time", self.dataset["time"])
            if unit_of(radius) not in ("1", self._unit("m")):
                try:
                    radius = radius.copy(data=in_si(with_unit(radius), "length"))
                except SceneError as error:
                    raise SceneError(f"radius: {error}") from None
        radii = np.asarray(radius, dtype=float)
        require_positive(radius=radii[~np.isnan(radii)] if radii.ndim else radii)
        ratio = self.about_axis(axis) / (self._named("mass") * radii**2)
        attrs = f"with R = {radius:g} {self._unit('m')}" if isinstance(radius, float | int) else "with the R given"
        return self._series(ratio.values, f"moment of inertia about {axis_text(axis)} over M R^2", "1", attrs)

    @property
    @of_each_member
    def quadrupole(self) -> xr.DataArray:
        """The reduced quadrupole Q - tr(Q)/3 1, (time, i, j).

        >>> print(bool(abs(np.trace(ds.inertia.quadrupole[0])) < 1e-12 * np.trace(ds.second_moment[0])))
        True
        """
        second = tensor.second_moment_from_inertia(self._values("inertia_tensor"))
        reduced = second - np.trace(second, axis1=1, axis2=2)[:, None, None] / 3 * np.eye(3)
        found = self._named("inertia_tensor").transpose("time", "i", "j").copy(data=reduced).rename("quadrupole")
        found.attrs = {"units": unit_of(found), "long_name": "reduced quadrupole", "comment": "Q - tr(Q) 1 / 3"}
        return found

    @with_quantities()
    def gravity_field(
        self,
        degree: int = 8,
        radius: float | None = None,
        normalization: str = "4pi",
        csphase: int = 1,
        principal_axes: bool = False,
    ) -> xr.Dataset:
        """Harmonics of the gravity field at each snapshot: harmonic_coefficient and zonal_harmonic (J_l, about z).

        About the centre of mass, in the axes of the dataset or in the principal axes at that time, z that of the
        largest moment; with the reference radius of the reader's choice or the one at that time that zonal_harmonic_2
        refers to. Conventions as of inertia.gravity_field. Without particles, a body that keeps its similar layers has
        its field at every record, to degree 20. 1e5 particles take 0.04 s a snapshot to degree 8 and 1 s to degree 50.
        AbsentError where there is neither.

        >>> field = ds.inertia.gravity_field()
        >>> c20 = field.harmonic_coefficient.sel(part="C", degree=2, order=0)
        >>> print(f"{float(c20[0] * np.sqrt(5) / ds.gravity_coefficient[0, 0]):.6f}")  # one is 4 pi normalised
        1.000000
        """
        must_be_of_one_run(self.dataset, "the gravity field")
        must_have_times(self.dataset)
        times, fields = run_fields(self.dataset, self.snapshots, degree, radius)
        if principal_axes:
            fields = [field.in_principal_axes() for field in fields]
        time = str(times.dims[0])
        attrs = {"units": self._unit("m"), "long_name": "reference radius of the gravity field"}
        variables = field_variables(fields, (time,), normalization, csphase)
        variables["reference_radius"] = ((time,), np.array([field.radius for field in fields]), attrs)
        return xr.Dataset(variables, {time: times, **field_labels(degree)})

    @with_quantities()
    @of_each_member
    def acceleration_shares(self, axis: Axis | None = None) -> xr.DataArray:
        """What motion and each effect contribute to d2I/dt2, (time, share[, i, j]); the shares add up to the whole.

        The first share is that of the kinetic tensor, 2 (tr(K) 1 - K), called "motion"; an effect's is tr(S) 1 - S with
        S = V + V^T. With an axis, the component n.(d2I/dt2).n along it.

        >>> print(np.sign(ds.inertia.acceleration_shares("z")[0, 1:3].values))  # gravity pulls, pressure pushes
        [-1.  1.]
        """
        kinetic = 2.0 * self._values("kinetic_tensor")[:, None]
        shares = tensor.inertia_from_second_moment(
            np.concatenate([kinetic, tensor.twice_symmetric(self._values("virial_tensor"))], axis=1)
        )
        dims: tuple[str, ...] = ("time", "share", "i", "j")
        if axis is not None:
            direction = np.broadcast_to(self._axis(axis), (shares.shape[0], 3))
            shares, dims = np.einsum("ti,teij,tj->te", direction, shares, direction), ("time", "share")
        return self._shares(shares, dims, "share in the second time derivative of the inertia tensor", "kg m2 s-2")

    @of_each_member
    def virial_shares(self) -> xr.DataArray:
        """The terms of the scalar virial, (time, share): tr K for motion, tr V for an effect.

        They add up to half the second time derivative of tr Q.

        >>> shares = ds.inertia.virial_shares()[0]
        >>> print(f"{float(-shares[2] / shares[1]):.1f}")  # pressure lacks a third of what gravity has
        0.7
        """
        motion = np.trace(self._values("kinetic_tensor"), axis1=1, axis2=2)[:, None]
        effects = np.trace(self._values("virial_tensor"), axis1=2, axis2=3)
        shares = np.concatenate([motion, effects], axis=1)
        return self._shares(shares, ("time", "share"), "share in the scalar virial", "J")

    @with_quantities()
    @of_each_member
    def torque_shares(self, axis: Axis = "z") -> xr.DataArray:
        """The torque of each effect along an axis, (time, effect).

        >>> print(ds.inertia.torque_shares().sizes["effect"])  # none of which turns the star
        3
        """
        torque = self._named("torque").transpose("time", "effect", "i")
        direction = np.broadcast_to(self._axis(axis), (self.dataset.sizes["time"], 3))
        along = np.einsum("tei,ti->te", torque.values, direction)
        share = xr.DataArray(along, self._coordinates("time", "effect"), ("time", "effect"))
        return share.rename("torque").assign_attrs(torque.attrs | {"long_name": f"torque along {axis_text(axis)}"})

    def spin_rate(self, as_size: bool | None = None) -> xr.DataArray:
        """The mean angular velocity about the axis of the angular momentum, L.n / n.I.n, n its direction.

        It is negative where L has turned round since the start. Where that axis moves far, as a top's, in the run or in
        any member of a sweep: |I^-1 L|, the size of the mean angular velocity. `long_name` says which it is; as_size
        chooses.

        >>> print(f"{float(ds.inertia.spin_rate()[0]):.1e} rad/s")  # as the scene has it
        1.0e-04 rad/s
        """
        if as_size is None:
            as_size = self.axis_moves()
        return self._spin_rate(as_size)

    def axis_moves(self) -> bool:
        """Whether the axis of the angular momentum moves far in the run, or in any member of a sweep.

        >>> print(ds.inertia.axis_moves())
        False
        """
        return bool((self._axis_moves() == 1.0).any())

    @of_each_member
    def _axis_moves(self) -> xr.DataArray:
        return xr.DataArray(float(self._momentum_axes() is None))

    @of_each_member
    def _spin_rate(self, as_size: bool) -> xr.DataArray:
        unit, axes = self._unit("rad s-1"), None if as_size else self._momentum_axes()
        if axes is None:
            inertia, momenta = self._values("inertia_tensor"), self._vectors("angular_momentum")
            known = "angular_velocity" in self.dataset
            spin = self._vectors("angular_velocity") if known else angular_velocity(inertia, momenta)
            rate = np.linalg.norm(spin, axis=1)
            return self._series(rate, "size of the mean angular velocity, whose axis moves", unit, "|I^-1 L|")
        rate = np.einsum("ti,ti->t", self._vectors("angular_momentum"), axes.values) / self.about_axis(axes).values
        return self._series(rate, "mean angular velocity about the axis of the angular momentum", unit, "L.n / n.I.n")

    @with_quantities()
    @of_each_member
    def spin_scaling(self, law: str = "inertia") -> xr.DataArray:
        """The spin that a scaling law predicts from the first output on.

        "inertia": omega_0 I_0 / I, which is exact where the angular momentum stays; "radius": omega_0
        (R_0 / R)^2 with the mean radius, which also needs the shape and the profile to stay; NaN for an infinitely thin
        disc or rod, whose mean radius is zero. Raises ValueError for another law.

        >>> print(f"{float((ds.inertia.spin_rate() / ds.inertia.spin_scaling())[-1]):.6f}")  # L stays, so 1/I holds
        1.000000
        """
        # What a body that begins at rest has is round-off.
        momentum = np.linalg.norm(self._vectors("angular_momentum"), axis=1)
        first = earliest(self.dataset["time"], momentum)
        opening = self.spin_rate().values[first] if momentum[first] > self._least_momentum() else 0.0
        if law == "inertia":
            axes = self._momentum_axes()
            size = self.about_axis("spin" if axes is None else axes).values
        elif law == "radius":
            moments = self._named("principal_moments").transpose("time", "principal").values
            largest = moments.max(axis=1)
            thin = moments.sum(axis=1) - 2.0 * largest <= _THINNEST * largest
            size = np.where(thin, np.nan, self._named("mean_radius").values ** 2)
        else:
            raise ValueError(f'the scaling laws are "inertia" and "radius", not {law!r}')
        text = {"inertia": "spin if the angular momentum stays", "radius": "spin if the body also keeps its shape"}[law]
        return self._series(opening * size[first] / size, text, self._unit("rad s-1"), f"scaling with {law}")

    @with_quantities()
    @of_each_member
    def rotation_limits(self, shedding: str = "roche") -> xr.Dataset:
        """Period, radius, periods of an orbit at the equator and of mass shedding, and flags of break-up, along time.

        The radius of these limits is the mean radius of the surface, or in older files that of the start, scaled with
        the mean radius by second moments. breakup_fraction is of an orbit at the body's own equator, with its J2, as
        [body] has it, where the dataset has its surface; there a body of particles or an ellipsoid, which rotation has
        flattened, sheds mass where that reaches 1, and the limit of shedding is for a body as it would be at rest.
        shedding: "roche", "polytrope n" or a published fit, as bodies.break_up.shedding_share has them; ValueError
        for another. The last two flags say whether T/|W| (shell by shell, where shells are known) lets friction make a
        bar, and whether it makes one by itself.

        >>> print(f"{float(ds.inertia.rotation_limits().kepler_fraction[0]):.2f}")  # of the rate of an orbit
        0.16
        """
        from astroinertia.dataset.rotation_limits import rotation_limits  # brings figures of stars along

        self._must_be_inertial("limits of rotation")
        self._must_have("mass", "mean_radius", "angular_velocity", "moment_ratio", "rotational_to_gravitational")
        series = rotation_limits(self.dataset, shedding)
        return xr.Dataset(
            {name: self._series(values, text, self._unit(unit), "") for name, (values, unit, text) in series.items()}
        )

    @with_quantities()
    @of_each_member
    def strain(self, polar_angle: float, azimuth: float = 0.0) -> xr.Dataset:
        """Gravitational-wave strain times distance for an observer at (theta, phi) in radians; variables plus, cross.

        Of the whole body, also where effects have been chosen. Raises ValueError for a dimensionless dataset, in which
        the speed of light has no value.

        >>> print(list(ds.inertia.strain(0.0)))
        ['plus', 'cross']
        """
        gravity = arranged.gravitational_constant(self.dataset)
        if gravity == 1.0:
            raise ValueError("the dataset is dimensionless: the speed of light has no value in it")
        self._must_be_inertial("the waves of a body")
        if "inertia_acceleration" in self.dataset:
            acceleration = -self._values("inertia_acceleration")  # whose traces do not radiate
        else:
            virials = self._values("virial_tensor")
            had = np.isfinite(virials).any(axis=(0, 2, 3))  # rows of effects that the model skips are NaN
            acceleration = second_moment_acceleration(self._values("kinetic_tensor"), virials[:, had].sum(axis=1))
        plus, cross = gravitational_wave_strain(acceleration, polar_angle, azimuth, gravitational_constant=gravity)
        names = {"plus": plus, "cross": cross}
        text = "gravitational-wave strain times distance"
        return xr.Dataset({name: self._series(values, f"{text}, {name}", "m", "") for name, values in names.items()})

    @with_quantities(start="s", end="s")
    @of_each_member
    def growth_rate(
        self, series: str | xr.DataArray = "bar_strength", start: float | None = None, end: float | None = None
    ) -> xr.Dataset:
        """The rate at which a quantity grows as exp(rate t) between two times: rate, its error, and rms of ln A left.

        series: a name, or a series of time such as `dataset.mode_amplitude.sel(mode=2)`; times in the dataset's unit.
        Raises ValueError where fewer than three values are known and not zero.

        >>> print(float(ds.inertia.growth_rate("density_max").rate) > 0)  # it falls together
        True
        """
        values = self._between(self._named(series), start, end)
        fitted = growth.growth(values["time"].values, values.values)
        return self._line(fitted, "growth rate", "s-1")

    @with_quantities(start="s", end="s")
    @of_each_member
    def pattern_speed(self, mode: int = 2, start: float | None = None, end: float | None = None) -> xr.Dataset:
        """The mean rate at which an azimuthal mode turns between two times, the slope of its phase: rate and error.

        Raises ValueError where the mode turns too far between two records for its turns to be counted, AbsentError
        where there is no such mode.

        >>> print(list(ds.inertia.pattern_speed()))
        ['rate', 'error', 'residual']
        """
        if reason := self.absent.get("mode_phase"):
            raise AbsentError(f"this run has no azimuthal mode of order {mode}: {reason}.")
        self._must_have("mode_phase")
        if mode not in self._named("mode").values:
            orders = ", ".join(map(str, self._named("mode").values))
            raise InputError(f"mode must be one of the orders that are recorded, {orders}, not {mode!r}.")
        modes = self._between(self.dataset.sel(mode=mode), start, end)
        phase = modes["mode_phase"]
        if "mode_amplitude" in modes:
            phase = phase.where(modes["mode_amplitude"] > _NO_MODE)
            if phase.isnull().all():
                raise AbsentError(f"the azimuthal mode of order {mode} has no size here, so its phase is undefined.")
        fitted = growth.turning(phase["time"].values, phase.values, mode)
        return self._line(fitted, f"pattern speed of mode {mode}", "rad s-1")

    @picture("moments", "inertia_figure")
    def plot_inertia(self, **options: Any) -> Any:
        """I(t) evolved against direct, with the closure."""

    @picture("spin", "spin_figure")
    def plot_spin(self, **options: Any) -> Any:
        """Spin against the scalings with 1/I and R^-2, over them, and T/|W|."""

    @picture("attitude", "attitude_figure")
    def plot_attitude(self, **options: Any) -> Any:
        """Rates about the body's own axes, Euler angles and the polhode, of a rigid body."""

    @picture("ledger", "ledger_figure")
    def plot_ledger(self, **options: Any) -> Any:
        """Each effect's share in d2I/dt2, and the angular momentum that it has given."""

    @picture("shape", "shape_figure")
    def plot_shape(self, **options: Any) -> Any:
        """Semi-axes, axis ratios and outlines of the equivalent ellipsoid."""

    @picture("energy", "energy_figure")
    def plot_energy(self, **options: Any) -> Any:
        """Energies, each effect's work and heating, and the errors."""

    @picture("error_bars", "error_bars_figure")
    def plot_error_bars(self, **options: Any) -> Any:
        """Error bars over the values that they belong to, of a run that has them."""

    @picture("waves", "waves_figure")
    def plot_waves(self, **options: Any) -> Any:
        """Gravitational-wave strain times distance."""

    @picture("density", "density_figure", of_particles=True)
    def plot_density(self, **options: Any) -> Any:
        """Slices of the density at the start, at maximum compression and at the end, from the snapshots."""

    @picture("profiles", "profiles_figure")
    def plot_profiles(self, **options: Any) -> Any:
        """Density, rotation and specific angular momentum against radius, at several times."""

    def _drawn(self, start: Any = None, end: Any = None, snapshots: xr.Dataset | None = None) -> dict[str, xr.Dataset]:
        """What a picture is drawn from, between two times; with the particles where they are given."""
        low, high = self._time("start", start), self._time("end", end)
        parts = {"dataset": begun(self._between(self.dataset.sortby("time").drop_duplicates("time"), low, high))}
        if snapshots is not None:
            taken, drawn = snapshots["snapshot_time"].values, parts["dataset"]["time"].values
            first, last = (float(taken[abs(taken - edge).argmin()]) for edge in (drawn[0], drawn[-1]))
            ends = (first if low is None else low, last if high is None else high)
            parts["snapshots"] = self._between(snapshots, *ends, "snapshot_time")
        return parts

    def _must_be_inertial(self, what: str) -> None:
        if (frame := self.dataset.attrs.get("frame", INERTIAL)) != INERTIAL:
            raise AbsentError(f"{what} follow from rates in an inertial frame, and that of this run is {frame}.")

    def _named(self, series: str | xr.DataArray) -> xr.DataArray:
        """A variable by its name, or the series itself, with its times in seconds."""
        if isinstance(series, xr.DataArray):
            return in_seconds(series)
        if not isinstance(series, str):
            raise InputError(f"a series is a name or a DataArray, not something of the type {type(series).__name__}.")
        if series not in self.dataset.variables:
            near = _nearest(series, self.dataset.data_vars.keys() - self.absent.keys())
            raise AbsentError(f"this dataset has no {shown(series)!r}; {near}")
        return self.dataset[series]

    def _must_have(self, *names: str) -> list[str]:
        """These names; AbsentError for the first that this dataset lacks, as one of which a part was taken may."""
        return [str(self._named(name).name) for name in names]

    def _time(self, name: str, value: Any) -> float | None:
        """A time in the unit of the dataset, from a number, a quantity or text with a unit."""
        if value is None or isinstance(value, int | float):
            return value
        try:
            quantity = with_unit(value)
            return quantity_of(value, "time") if isinstance(value, str) else float(in_si(quantity, "time"))
        except SceneError as error:
            raise SceneError(f"{name}: {error}") from None
        except (AttributeError, TypeError):
            raise SceneError(f"{name} must be a time, not something of the type {type(value).__name__}.") from None

    def _between(self, series: Any, start: float | None, end: float | None, along: str = "time") -> Any:
        if along not in series.dims:
            raise SceneError(f"{series.name} does not vary along {along}.")
        time = series[along]
        low, high = -np.inf if start is None else start, np.inf if end is None else end
        inside = np.flatnonzero((time >= low) & (time <= high))
        if not len(inside):
            raise SceneError(f"nothing is recorded from start = {low:g} to end = {high:g} in the dataset's {along}.")
        return series if len(inside) == time.size else series.isel({along: inside})

    def _line(self, fitted: growth.Line, text: str, unit: str) -> xr.Dataset:
        values = {"rate": (fitted.slope, text), "error": (fitted.error, f"standard error of the {text}")}
        units = {"units": self._unit(unit)}
        variables = {name: ((), value, units | {"long_name": words}) for name, (value, words) in values.items()}
        left = {"units": "1", "long_name": "rms of what the straight line leaves"}
        return xr.Dataset({**variables, "residual": ((), fitted.residual, left)})

    def _unit(self, unit: str) -> str:
        return "1" if unit_of(self._named("mass" if "mass" in self.dataset else "inertia_tensor")) == "1" else unit

    def _values(self, name: str) -> np.ndarray:
        series = self._named(name)
        dims = ("time", *(("effect",) if "effect" in series.dims else ()), "i", "j")
        return series.transpose(*dims).values

    def _vectors(self, name: str) -> np.ndarray:
        return self._named(name).transpose("time", "i").values

    def _axis(self, axis: Axis) -> np.ndarray:
        spin = isinstance(axis, str) and axis == "spin"
        return self._vectors("spin_axis") if spin else directions(axis, self.dataset["time"])

    def _momentum_axes(self) -> xr.DataArray | None:
        """The direction of the angular momentum, (time, i), to the side of that at the start; None where it moves far.

        z where there is none at the start, and that at the start where there is none later.
        """
        momenta = self._vectors("angular_momentum")
        sizes, least = np.linalg.norm(momenta, axis=1), self._least_momentum()
        first = earliest(self.dataset["time"], sizes)
        axis = momenta[first] / sizes[first] if sizes[first] > least else np.eye(3)[2]
        sideways = np.linalg.norm(momenta - np.outer(momenta @ axis, axis), axis=1)
        if np.nanmax(sideways) > max(_TURNED * np.nanmax(sizes), least):
            return None
        # A torque may bring it almost to rest, when what is left of it sideways says nothing of the axis.
        along = (abs(momenta @ axis) > sideways) & (sizes > least)
        signed = momenta * np.sign(momenta @ axis)[:, None] / np.where(along, sizes, 1.0)[:, None]
        directions = np.where(along[:, None], signed, axis)
        return xr.DataArray(directions, self._coordinates("time", "i"), ("time", "i"))

    def _least_momentum(self) -> float:
        """An angular momentum that is no more than the round-off of its sum at the start."""
        kinetic = self._values("kinetic_tensor")[0].trace() if "kinetic_tensor" in self.dataset else 0.0
        spread = self._values("inertia_tensor")[0].trace() / 2.0 * kinetic
        return SPINLESS * float(np.sqrt(spread)) if np.isfinite(spread) else 0.0

    def _series(self, values: np.ndarray, long_name: str, unit: str, comment: str) -> xr.DataArray:
        attrs = {"units": unit, "long_name": long_name} | ({"comment": comment} if comment else {})
        return xr.DataArray(values, self._coordinates("time"), ("time",), attrs=attrs)

    def _coordinates(self, *dims: str) -> dict[Any, xr.Variable]:
        """The dataset's coordinates along these dimensions, and those without one, such as what an ensemble varies."""
        return {name: labels.variable for name, labels in self.dataset.coords.items() if set(labels.dims) <= set(dims)}

    def _shares(self, values: np.ndarray, dims: tuple[str, ...], long_name: str, unit: str) -> xr.DataArray:
        names = np.array([MOTION, *self._named("effect").values.tolist()], dtype=str)
        coords: dict[str, Any] = {"share": names} | self._coordinates(*dims)
        return xr.DataArray(values, coords, dims, attrs={"units": self._unit(unit), "long_name": long_name})


def _nearest(name: str, names: Any) -> str:
    close = difflib.get_close_matches(name, list(map(str, names)), n=1)
    return f"did you mean {close[0]!r}?" if close else "its data_vars are what it has."
