"""Integrates a vehicle of the library once more, with SciPy and from equations written independently, and compares.

    vehicles.py NAME RUN.npz      (RUN.npz: what `phalanx export --format npz` wrote of a run with one agent)

Prints the largest difference of any state relative to its size; exit code 1 if it is above 1e-9.
"""

import sys

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

TOLERANCE = 1e-9


def integrator(order):
    def rates(states, inputs):
        return inputs if order == 1 else np.r_[states[len(inputs) :], inputs]

    return rates


def unicycle(states, inputs):
    direction = np.exp(1j * states[2])
    return [inputs[0] * direction.real, inputs[0] * direction.imag, inputs[1]]


def bicycle(states, inputs):
    speed, steering = inputs[0], np.clip(inputs[1], -0.6, 0.6)
    direction = np.exp(1j * states[2])
    return [speed * direction.real, speed * direction.imag, speed / 2.7 * np.tan(steering)]


def dubins_aeroplane(states, inputs):
    climb, turn = np.clip(inputs[0], -2, 2), np.clip(inputs[1], -0.5, 0.5)
    direction = 15 * np.exp(1j * states[3])
    return [direction.real, direction.imag, climb, turn]


def surface_vessel(states, force):
    psi, nu = states[2], states[3:]
    u, v, r = nu
    rigid = np.array([[23.8, 0, 0], [0, 23.8, 23.8 * 0.046], [0, 23.8 * 0.046, 1.76]])
    added = np.diag([2.0, 10.0, 1.0])
    mass = rigid + added
    momentum = mass @ nu
    coriolis = np.array([[0, 0, -momentum[1]], [0, 0, momentum[0]], [momentum[1], -momentum[0], 0]])
    damping = np.array(
        [
            [0.72253 + 1.32742 * abs(u) + 5.86643 * u**2, 0, 0],
            [0, 0.88965 + 36.47287 * abs(v) + 0.805 * abs(r), 7.25 + 0.845 * abs(v) + 3.45 * abs(r)],
            [0, -0.0313 - 3.95645 * abs(v) - 0.13 * abs(r), 1.9 - 0.08 * abs(v) + 0.75 * abs(r)],
        ]
    )
    turn = np.array([[np.cos(psi), -np.sin(psi), 0], [np.sin(psi), np.cos(psi), 0], [0, 0, 1]])
    return np.r_[turn @ nu, np.linalg.solve(mass, force - coriolis @ nu - damping @ nu)]


def quaternion_rate(q, omega):
    """Half of the product of q = (w, x, y, z) and (0, omega)."""
    w, vector = q[0], q[1:]
    return 0.5 * np.r_[-vector @ omega, w * omega + np.cross(vector, omega)]


def rigid_rate(inertia, omega, torque):
    return np.linalg.solve(inertia, torque - np.cross(omega, inertia @ omega))


def rotor_craft(mass, arm, inertia, kappa, most):
    places = arm * np.array([[1, -1, 0], [-1, -1, 0], [-1, 1, 0], [1, 1, 0]]) / np.sqrt(2)
    senses = np.array([1, -1, 1, -1])

    def rates(states, inputs):
        thrusts = np.clip(inputs, 0, most)
        velocity, q, omega = states[3:6], states[6:10], states[10:]
        up = Rotation.from_quat([*q[1:], q[0]]).apply([0, 0, 1])
        torque = sum(np.cross(place, [0, 0, f]) for place, f in zip(places, thrusts)) + [0, 0, kappa * senses @ thrusts]
        acceleration = up * thrusts.sum() / mass - [0, 0, 9.81]
        return np.r_[velocity, acceleration, quaternion_rate(q, omega), rigid_rate(np.diag(inertia), omega, torque)]

    return rates


def spacecraft(states, torque):
    inertia = np.diag([0.9, 1.1, 1.4])
    return np.r_[quaternion_rate(states[:4], states[4:]), rigid_rate(inertia, states[4:], torque)]


def two_link_arm(states, torque):
    """From the Lagrangian of two rods: mass matrix and its derivatives by the Jacobians of the centres of mass."""
    q, w = states[:2], states[2:]

    def jacobians(q):
        first, both = q[0], q[0] + q[1]
        centre1 = 0.5 * np.array([[-np.sin(first), 0], [np.cos(first), 0]])
        centre2 = np.array(
            [[-np.sin(first) - 0.5 * np.sin(both), -0.5 * np.sin(both)], [np.cos(first) + 0.5 * np.cos(both), 0.5 * np.cos(both)]]
        )
        return centre1, centre2

    def mass_matrix(q):
        centre1, centre2 = jacobians(q)
        turns1, turns2 = np.array([[1, 0], [0, 0]]), np.array([[1, 1], [1, 1]])
        return centre1.T @ centre1 + centre2.T @ centre2 + 0.0833 * (turns1 + turns2)

    # The mass matrix depends on q2 only, and is linear in its cosine.
    slope = -np.sin(q[1]) * (mass_matrix([0, 0]) - mass_matrix([0, np.pi])) / 2
    gravity = sum(9.81 * jacobian[1] for jacobian in jacobians(q))
    coriolis = slope @ w * w[1] - 0.5 * np.array([0, w @ slope @ w])
    return np.r_[w, np.linalg.solve(mass_matrix(q), torque - coriolis - gravity)]


MODELS = {
    **{f"single_integrator_{n}d": ("xyz"[:n], integrator(1)) for n in (1, 2, 3)},
    **{f"double_integrator_{n}d": ([*"xyz"[:n], *(f"v{c}" for c in "xyz"[:n])], integrator(2)) for n in (1, 2, 3)},
    "unicycle": (["x", "y", "theta"], unicycle),
    "bicycle": (["x", "y", "theta"], bicycle),
    "dubins_aeroplane": (["x", "y", "z", "psi"], dubins_aeroplane),
    "surface_vessel": (["x", "y", "psi", "u", "v", "r"], surface_vessel),
    "quadrotor": (
        "x y z vx vy vz qw qx qy qz wx wy wz".split(),
        rotor_craft(0.5, 0.17, [2.32e-3, 2.32e-3, 4e-3], 0.016, 4),
    ),
    "crazyflie": (
        "x y z vx vy vz qw qx qy qz wx wy wz".split(),
        rotor_craft(0.027, 0.046, [16.571710e-6, 16.655602e-6, 29.261652e-6], 0.005964552, 0.16),
    ),
    "spacecraft": ("qw qx qy qz wx wy wz".split(), spacecraft),
    "two_link_arm": (["q1", "q2", "w1", "w2"], two_link_arm),
}


def main(name, path):
    names, rates = MODELS[name]
    run = np.load(path)
    expected = np.column_stack([run[f"agent_1_state_{state}"].ravel() for state in names])
    inputs, times = run["agent_1_command_input"].reshape(len(expected), -1), run["t"]
    states, worst = expected[0], 0.0
    size = np.maximum(1, np.abs(expected).max(axis=0))
    for k in range(len(times) - 1):
        span = (0, times[k + 1] - times[k])
        solved = solve_ivp(
            lambda _, x: np.asarray(rates(x, inputs[k])), span, states, method="DOP853", rtol=1e-13, atol=1e-14
        )
        states = solved.y[:, -1]
        worst = max(worst, (np.abs(states - expected[k + 1]) / size).max())
    moved = (np.abs(expected - expected[0]).max(axis=0) > 1e-3).sum()
    print(f"{name}: {worst:.1e} after {times[-1]} s, {moved} of {len(names)} states moved")
    sys.exit(int(worst > TOLERANCE or moved < len(names)))


main(*sys.argv[1:])
