"""Distributed model predictive control of one robot of `formation.toml`.

    phalanx run formation.toml

At every step the robot minimises, over the accelerations u_0 ... u_{H-1} of its horizon, for x and y alike,

    sum_k  b q |p_k - r_k|^2  +  sum_j a_j f |p_k - (plan_j,k + d_j)|^2  +  e |u_k|^2,     |u_k| <= most,

where p_k are its positions, r_k those of its reference, plan_j the positions that neighbour j predicted at the step before, and
d_j its offset to that neighbour in the formation. Projected gradient steps solve it.
"""

import numpy as np

import phalanx

ITERATIONS = 80


def prediction(horizon, dt):
    """Positions after k steps of a double integrator: start + k dt velocity + matrix @ accelerations."""
    ahead = np.arange(1, horizon + 1)[:, None] - np.arange(horizon)[None, :]
    return np.where(ahead > 0, (ahead - 0.5) * dt * dt, 0.0)


def shifted(plan):
    """A plan of the step before, one step on: its last motion continues."""
    return np.append(plan[1:], 2 * plan[-1] - plan[-2])


class Axis:
    """One coordinate of the robot."""

    def __init__(self, index, matrix, weights):
        self.index, self.matrix = index, matrix
        self.hessian = sum(weights) * matrix.T @ matrix
        self.inputs = np.zeros(len(matrix))

    def plan(self, free, targets, effort, most):
        """The accelerations and the cost; `free` are the positions without any, `targets` pairs of weight and positions."""
        hessian = self.hessian + effort * np.eye(len(free))
        gradient = self.matrix.T @ sum(weight * (free - target) for weight, target in targets)
        rate = 1.0 / np.linalg.norm(hessian, np.inf)
        inputs = np.append(self.inputs[1:], 0.0)
        for _ in range(ITERATIONS):
            inputs = np.clip(inputs - rate * (hessian @ inputs + gradient), -most, most)
        self.inputs = inputs
        positions = free + self.matrix @ inputs
        misses = sum(weight * np.sum((positions - target) ** 2) for weight, target in targets)
        return positions, misses + effort * np.sum(inputs**2)


with phalanx.Participant() as me:
    position, velocity = me.state("position"), me.state("velocity")
    reference, speed, turn = (me.reference(name) for name in ("position", "velocity", "acceleration"))
    others = {
        j: (me.state("position", agent=j), me.reference("position", agent=j), me.read("controller", "plan", agent=j, before=True))
        for j in me.neighbours()
    }
    command, plan, cost = me.output("input"), me.output("plan"), me.output("cost")

    horizon = len(plan) // 2
    tracking, effort, most = me.b() * me.parameter("tracking"), me.parameter("effort"), me.parameter("most")
    formation = {j: me.weight(me.agent, j) * me.parameter("formation") for j in others}
    matrix, times = prediction(horizon, me.dt), me.dt * np.arange(1, horizon + 1)
    axes = [Axis(index, matrix, [tracking, *formation.values()]) for index in (0, 1)]

    for step in me:
        predicted, costs = [], 0.0
        for axis in axes:
            k = axis.index
            targets = [(tracking, reference.value[k] + times * speed.value[k] + times**2 / 2 * turn.value[k])]
            for j, (state, place, plan_before) in others.items():
                # Before the first plan: the neighbour stays where it is.
                theirs = plan_before.value[k * horizon : (k + 1) * horizon]
                theirs = np.full(horizon, state.value[k]) if step.index == 0 else shifted(theirs)
                targets.append((formation[j], theirs + (reference.value[k] - place.value[k])))
            free = position.value[k] + times * velocity.value[k]
            positions, of_axis = axis.plan(free, targets, effort, most)
            predicted.append(positions)
            costs += of_axis
        heading = -2.0 * position.value[2] - 3.0 * velocity.value[2]
        command.value = [axes[0].inputs[0], axes[1].inputs[0], np.clip(heading, -most, most)]
        plan.value = np.concatenate(predicted)
        cost.value = [costs]
