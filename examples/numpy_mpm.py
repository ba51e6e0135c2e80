"""Explicit MPM in NumPy alone, for teaching: the whole method on two screens. It is a thousand times slower than the core.

Source: Sulsky, Chen & Schreyer (1994), update stress last; letters as in docs/notation.md.
Expected: positions, velocities and deformation gradients of the two disks agree with the core to round-off (1e-11) over 200 steps.
Runs in about 1 s.
"""

import matpoint as mp
import numpy as np
from disks import case


class NumpyMpm:
    """2D, linear shape functions, St. Venant-Kirchhoff solids that share one grid; particles of all bodies in one array."""

    def __init__(self, x, v, volume, *, h, cells, density, youngs_modulus, poissons_ratio, mass_cutoff):
        self.x, self.v, self.V0 = x.copy(), v.copy(), volume  # [m], [m/s], [m^2]
        self.F = np.tile(np.eye(2), (len(x), 1, 1))
        self.m = density * volume
        self.h, self.nodes, self.mass_cutoff = h, (cells[0] + 1, cells[1] + 1), mass_cutoff
        self.lam = youngs_modulus * poissons_ratio / ((1 + poissons_ratio) * (1 - 2 * poissons_ratio))
        self.mu = youngs_modulus / (2 * (1 + poissons_ratio))

    def shape_functions(self):
        """Nodes around each particle, (n, 4), their N_i(x_p), (n, 4), and grad N_i(x_p), (n, 4, 2)."""
        cell = np.floor(self.x / self.h).astype(int)
        xi = self.x / self.h - cell  # in [0, 1)
        corner = np.array([[0, 0], [1, 0], [0, 1], [1, 1]])
        along = np.where(corner, xi[:, None], 1 - xi[:, None])  # (n, 4, 2): the factors of N
        slope = np.where(corner, 1.0, -1.0) / self.h
        N = along[..., 0] * along[..., 1]
        grad = np.stack([slope[:, 0] * along[..., 1], along[..., 0] * slope[:, 1]], axis=2)
        node = cell[:, None] + corner
        return node[..., 0] * self.nodes[1] + node[..., 1], N, grad

    def kirchhoff_stress(self):
        """tau = F S F^T with S = lambda tr(E) I + 2 mu E and Green's strain E = (F^T F - I) / 2 [Pa]."""
        E = 0.5 * (self.F.transpose(0, 2, 1) @ self.F - np.eye(2))
        S = self.lam * np.trace(E, axis1=1, axis2=2)[:, None, None] * np.eye(2) + 2 * self.mu * E
        return self.F @ S @ self.F.transpose(0, 2, 1)

    def step(self, dt):
        """One step of dt [s]."""
        node, N, grad = self.shape_functions()
        count = self.nodes[0] * self.nodes[1]

        # Particles to grid: mass, momentum, internal force -V0 tau grad N.
        def sum_at_nodes(values):
            return np.bincount(node.ravel(), values.ravel(), count)

        m_i = sum_at_nodes(N * self.m[:, None])
        force = -self.V0[:, None, None] * np.einsum("pab,pib->pia", self.kirchhoff_stress(), grad)
        p_i = np.stack([sum_at_nodes(N * (self.m * self.v[:, d])[:, None]) for d in range(2)], axis=1)
        f_i = np.stack([sum_at_nodes(force[..., d]) for d in range(2)], axis=1)

        # The momentum equation, on nodes that have enough mass.
        active = (m_i > 0) & (m_i >= self.mass_cutoff)
        a_i, v_i = np.zeros_like(p_i), np.zeros_like(p_i)
        a_i[active] = f_i[active] / m_i[active, None]
        v_i[active] = p_i[active] / m_i[active, None] + dt * a_i[active]

        # Grid to particles: FLIP velocity, velocity gradient, position.
        self.v += dt * np.einsum("pi,pid->pd", N, a_i[node])
        L = np.einsum("pia,pib->pab", v_i[node], grad)
        self.x += dt * np.einsum("pi,pid->pd", N, v_i[node])
        self.F += dt * L @ self.F


def run(steps: int = 200) -> tuple[NumpyMpm, mp.Simulation]:
    """The same steps with both, from the moment before the disks touch (t = 1.2 s)."""
    simulation = case().build()
    simulation.step(12000)
    bodies = simulation.bodies.values()
    x, v, F = (np.concatenate([body.field(name) for body in bodies]) for name in ("position", "velocity", "deformation_gradient"))
    volume = np.concatenate([body.volume / body.J for body in bodies])
    law = {"density": 1000.0, "youngs_modulus": 1e4, "poissons_ratio": 0.3}
    ours = NumpyMpm(x, v, volume, h=0.05, cells=(20, 20), mass_cutoff=1e-10, **law)
    ours.F = F[:, :2, :2].copy()
    for _ in range(steps):
        ours.step(1e-4)
    simulation.step(steps)
    return ours, simulation


def check(done: tuple[NumpyMpm, mp.Simulation]) -> None:
    """Compares particle by particle."""
    ours, simulation = done
    bodies = simulation.bodies.values()
    assert np.abs(ours.x - np.concatenate([body.position for body in bodies])).max() < 1e-13
    assert np.abs(ours.v - np.concatenate([body.velocity for body in bodies])).max() < 1e-11
    assert np.abs(ours.F - np.concatenate([body.deformation_gradient for body in bodies])[:, :2, :2]).max() < 1e-11


if __name__ == "__main__":
    check(run())
