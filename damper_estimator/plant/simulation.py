"""Drives a damper through a displacement and records the true quantities."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from damper_estimator.plant import kernel
from damper_estimator.plant.damper import Damper, Parts, packed_share, parts_of
from damper_estimator.plant.parts import AMBIENT_PRESSURE
from damper_estimator.plant.solids import ELEMENTS

STEP = 1e-4
"""s, internal step of a simulation; its error is far below the sensors' noise (a test verifies it)."""


@dataclass(frozen=True)
class Drive:
    """Input of a damper: displacement (m) and coil current (A), shape (n,), every ``step`` seconds."""

    name: str
    step: float
    displacement: np.ndarray
    current: np.ndarray
    seed: int = 0

    @cached_property
    def velocity(self) -> np.ndarray:
        """First derivative, m/s."""
        return _derivative(self.displacement, self.step)

    @cached_property
    def acceleration(self) -> np.ndarray:
        """Second derivative, m/s^2."""
        return _derivative(self.velocity, self.step)

    @property
    def time(self) -> np.ndarray:
        """Seconds from the start."""
        return self.step * np.arange(self.displacement.size)


@dataclass(frozen=True)
class Truth:
    """A simulated record, noise-free, at the internal step; all arrays have shape (n,).

    ``force`` (N) is the reading of a perfect gauge between rod and body, without a parallel spring. Pressures in Pa,
    absolute; ``temperature`` in deg C; ``rod`` is the displacement below the mount (m), ``floating_piston`` that of the
    floating piston (m, into the gas); ``field`` the lagged coil current of the magnetic field (A).
    """

    damper: Damper
    drive: Drive
    force: np.ndarray
    rebound_pressure: np.ndarray
    compression_pressure: np.ndarray
    gas_pressure: np.ndarray
    temperature: np.ndarray
    floating_piston: np.ndarray
    rod: np.ndarray
    field: np.ndarray

    @property
    def time(self) -> np.ndarray:
        """Seconds from the start."""
        return self.drive.time

    @property
    def rms(self) -> float:
        """Root mean square of the force, N."""
        return float(np.sqrt(np.mean(self.force**2)))

    @property
    def rebound_void(self) -> np.ndarray:
        """Volume of free gas and vapour in the rebound chamber, m^3."""
        parts = parts_of(self.damper)
        volume = parts.chambers.rebound_volume - parts.chambers.rebound_area * self.rod
        above = self.rebound_pressure - parts.oil.vapour_pressure
        return volume * parts.oil.free_gas * AMBIENT_PRESSURE / above


def simulate(damper: Damper, drive: Drive) -> Truth:
    """The damper's response to a drive, from rest at its first displacement.

    Raises:
        ValueError: if the displacement leaves the damper's stroke or the drive is not finite.
    """
    _check(damper, drive)
    parts = parts_of(damper)
    memory = rest(parts, float(drive.displacement[0]), float(drive.current[0]))
    out = np.empty((drive.displacement.size, kernel.OUT_ROWS))
    work = np.zeros((kernel.WORK_ROWS, 7))
    kernel.integrate(parts, memory, work, drive.displacement, drive.velocity, drive.current, drive.step, out)
    columns = np.ascontiguousarray(out.T)
    if not parts.mount.stiffness:
        columns[kernel.FORCE] += parts.inertia * drive.acceleration
    return Truth(damper, drive, *columns)


def rest(parts: Parts, displacement: float, current: float = 0.0) -> np.ndarray:
    """Memory of a damper at rest: uniform pressure, no friction, shape (MEMORY_SIZE,)."""
    memory = np.zeros(kernel.MEMORY_SIZE)
    memory[kernel.TEMPERATURE] = parts.heat.start
    memory[kernel.FIELD] = abs(current)
    rod = displacement
    for _ in range(60 if parts.mount.stiffness else 1):  # the mount deflects a little under the gas force
        _settle(parts, memory, rod)
        rod = displacement - _mount_deflection(parts, memory, rod)
    memory[kernel.ROD] = rod
    travel = rod - memory[kernel.PACKED] / parts.chambers.rebound_area
    memory[kernel.SEAL : kernel.GEL] = rod
    memory[kernel.GEL : kernel.COIL + ELEMENTS] = travel
    memory[kernel.REBOUND_AREA], memory[kernel.COMPRESSION_AREA] = (
        kernel.lift_area(parts.rebound, 0.0),
        kernel.lift_area(parts.compression, 0.0),
    )
    return memory


def _settle(parts: Parts, memory: np.ndarray, rod: float) -> None:
    """Finds the floating piston's position with equal pressure of oil and gas; writes the oil states."""
    chambers = parts.chambers
    rod_volume = (chambers.compression_area - chambers.rebound_area) * rod
    rebound_volume = chambers.rebound_volume - chambers.rebound_area * rod
    low, high = -0.95 * chambers.compression_volume, 0.95 * chambers.gas_volume
    for _ in range(100):  # bisection to the last bit: more oil volume, less oil pressure, more gas pressure
        moved = 0.5 * (low + high)
        share = packed_share(parts.oil, kernel.gas_pressure(parts.gas, chambers.gas_volume, moved, 1.0))
        compression_volume = chambers.compression_volume + chambers.compression_area * rod + moved
        packed = share * rebound_volume - chambers.rebound_excess
        opened = chambers.compression_excess - share * compression_volume
        if opened - packed - rod_volume > moved:
            low = moved
        else:
            high = moved
    memory[kernel.PACKED], memory[kernel.OPENED] = packed, opened


def _mount_deflection(parts: Parts, memory: np.ndarray, rod: float) -> float:
    """Deflection in m at which the rubber balances the gas force."""
    if not parts.mount.stiffness:
        return 0.0
    rebound, compression, _, _ = kernel.pressures(parts, memory, memory, rod)
    force = kernel.rod_force(parts, memory, rebound, compression, rod, 0.0)
    force -= kernel.seal_force(parts, memory, rebound, rod, 0.0)
    deflection = 0.0
    for _ in range(50):
        deflection = force / (parts.mount.stiffness * (1.0 + (deflection / parts.mount.progression) ** 2))
    return deflection


def _check(damper: Damper, drive: Drive) -> None:
    geometry, travel = damper.geometry, drive.displacement
    if travel.shape != drive.current.shape or travel.ndim != 1 or travel.size < 5:
        shapes = f"{travel.shape} and {drive.current.shape}"
        raise ValueError(f"displacement and current must have one shape (n >= 5,), not {shapes}")
    if not (np.isfinite(travel).all() and np.isfinite(drive.current).all()):
        raise ValueError("displacement and current must be finite")
    if travel.max() > geometry.rebound_stroke or travel.min() < -geometry.compression_stroke:
        raise ValueError(
            f"displacement {1e3 * travel.min():.1f} to {1e3 * travel.max():.1f} mm leaves the stroke of {damper.name}, "
            f"{-1e3 * geometry.compression_stroke:.0f} to {1e3 * geometry.rebound_stroke:.0f} mm"
        )


def _derivative(values: np.ndarray, step: float) -> np.ndarray:
    """Fourth-order central differences; second-order at the two outermost samples of each end."""
    slope = np.gradient(values, step, edge_order=2)
    slope[2:-2] = (8.0 * (values[3:-1] - values[1:-3]) - (values[4:] - values[:-4])) / (12.0 * step)
    return slope
