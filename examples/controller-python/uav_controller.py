"""The controller of one quadcopter of section 7.2, in Python: position loop, guidance law, attitude loop.

    phalanx run uav --swap "controller.3=python3 examples/controller-python/uav_controller.py"

gives the same log as `phalanx run uav`, byte by byte: the operations are those of `hierarchical_uav` in the same order, and the
elementary functions are the ones that Phalanx uses. Equations are numbered as in the thesis.
"""

import math

import numpy as np

import phalanx
from phalanx import libm

UP = np.array([0.0, 0.0, 9.81])


class HeldSlope:
    """A limited derivative of a sampled vector, taken over `hold` steps and held that long. (7.32), (7.33), Algorithm 4"""

    def __init__(self, method: str, hold: int, limit: float, delay: int) -> None:
        self.method, self.hold, self.limit, self.delay = method, hold, limit, delay
        self.before, self.slope = np.zeros(3), np.zeros(3)
        self.slopes_taken = 0

    def update(self, index: int, dt: float, value: np.ndarray) -> np.ndarray:
        """The derivative at step `index`."""
        if index <= self.delay:
            self.slope, self.before = np.zeros(3), value
        elif self.method == "slope":
            self.slope, self.before = (value - self.before) / dt, value
        elif index >= self.slopes_taken * self.hold:
            self.slope, self.before = (value - self.before) / (self.hold * dt), value
            self.slopes_taken += 1
        elif self.method == "printed":
            self.before = value
        return np.clip(self.slope, -self.limit, self.limit)


class HierarchicalUav:
    """The law and its states."""

    def __init__(self, me: phalanx.Participant) -> None:
        gain = {name: me.number(f"controller.{name}") for name in ("lam_p", "c_p", "k_p", "lam_a", "c_a", "k_a")}
        self.lam_p, self.c_p, self.k_p, self.lam_a, self.c_a, self.k_a = gain.values()
        self.psi_d = me.number("controller.psi_d") if me.has("controller.psi_d") else 0.0
        self.intro = me.text("controller.intro")
        self.gamma1, self.gamma2 = me.number("controller.gamma1"), me.number("controller.gamma2")
        every = "controller.position_every"
        self.position_every = int(me.number(every)) if me.has(every) else 1
        method, hold = me.text("controller.diff"), int(me.number("controller.n_diff"))
        self.first = HeldSlope(method, hold, me.number("controller.xi1_max"), delay=1)
        self.second = HeldSlope(method, hold, me.number("controller.xi2_max"), delay=2)
        self.dt, self.mass = me.dt, me.model("m")
        arm, factor = me.model("R"), me.model("upsilon")
        self.effect = np.array([arm / me.model("Jx"), arm / me.model("Jy"), factor / me.model("Jz")])  # (7.3)
        self.push = self.attitude = self.xi1 = self.xi2 = self.sliding_p = self.sliding_a = np.zeros(3)

    def introduction(self, time: float) -> float:
        """How far the disturbance estimate is faded in. (7.40)"""
        if self.intro == "none":
            return 1.0
        decay = libm.exp(-self.gamma1 * (time - self.gamma2))
        return 1.0 / (1.0 + decay) if self.intro == "logistic" else (1.0 - decay) / (1.0 + decay)

    def update(self, step: phalanx.Step, x: np.ndarray, v: np.ndarray, reference: list, disturbance: np.ndarray) -> list:
        """Thrust and torques, in N."""
        introduced = self.introduction(step.time) * disturbance
        if step.index % self.position_every == 0:
            self.position_loop(x[:3], v[:3], reference, introduced[:3])
            self.guide()
            run, period = step.index // self.position_every, self.dt * self.position_every
            self.xi1 = self.first.update(run, period, self.attitude)
            self.xi2 = self.second.update(run, period, self.xi1)
        turn = self.attitude_loop(x[3:], v[3:], introduced[3:])
        roll, pitch = float(x[3]), float(x[4])
        thrust = self.mass * self.push[2] / (libm.cos(roll) * libm.cos(pitch))  # (7.43)
        return [thrust, *(turn / self.effect)]

    def position_loop(self, x: np.ndarray, v: np.ndarray, reference: list, disturbance: np.ndarray) -> None:
        """The acceleration that is asked for. (7.26), (7.41)"""
        position, velocity, acceleration = reference
        error, rate = x - position, v - velocity
        self.sliding_p = rate + self.lam_p * error
        push = acceleration - disturbance - self.lam_p * rate - self.k_p * error - self.c_p * self.sliding_p
        self.push = push + UP

    def guide(self) -> None:
        """Roll and pitch that point the thrust that way. (7.31)"""
        x, y, z = self.push.tolist()
        sin_yaw, cos_yaw = libm.sin(self.psi_d), libm.cos(self.psi_d)
        # Not numpy.linalg.norm, which adds up in an order of its own.
        length = math.sqrt(x * x + y * y + z * z)
        roll = libm.asin((x * sin_yaw - y * cos_yaw) / length)
        self.attitude = np.array([roll, libm.atan((x * cos_yaw + y * sin_yaw) / z), self.psi_d])

    def attitude_loop(self, x: np.ndarray, v: np.ndarray, disturbance: np.ndarray) -> np.ndarray:
        """The angular acceleration that is asked for. (7.36), (7.42)"""
        error, rate = x - self.attitude, v - self.xi1
        self.sliding_a = rate + self.lam_a * error
        return self.xi2 - disturbance - self.lam_a * rate - self.k_a * error - self.c_a * self.sliding_a


def main() -> None:
    with phalanx.Participant() as me:
        law = HierarchicalUav(me)
        x, v = me.state("position", 6), me.state("velocity", 6)
        reference = [me.reference(name, 3) for name in ("position", "velocity", "acceleration")]
        disturbance = me.estimate("disturbance", 6)
        command = me.output("input", 4)
        names = ("attitude_reference", "xi1", "xi2", "sliding_position", "sliding_attitude")
        shown = [me.output(name, 3) for name in names]
        for step in me:
            wanted = [signal.value for signal in reference]
            command.value = law.update(step, x.value, v.value, wanted, disturbance.value)
            for output, value in zip(shown, (law.attitude, law.xi1, law.xi2, law.sliding_p, law.sliding_a)):
                output.value = value


if __name__ == "__main__":
    main()
