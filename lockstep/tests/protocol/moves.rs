//! The accesses themselves, each in one indivisible move.

use crate::model::{Actor, After, At, Flaw, Run, State};

/// Bit of a gate that says: no further step.
const STOP: u8 = 0x80;

/// Phase of a worker, and its bit there.
fn place(run: &Run, worker: usize) -> (usize, u8) {
    let mut first = 0;
    for (phase, &size) in run.sizes.iter().enumerate() {
        if worker < first + usize::from(size) {
            return (phase, 1 << (worker - first));
        }
        first += usize::from(size);
    }
    unreachable!("the conductor is no worker")
}

impl State {
    pub(crate) fn wake_conductor(&mut self) {
        if let Some(conductor) = self.actors.last_mut().filter(|conductor| conductor.at == At::Asleep) {
            conductor.at = At::Rings;
        }
    }

    fn wake_workers(&mut self, run: &Run, phase: u8) {
        let last = self.actors.len() - 1;
        for (worker, actor) in self.actors[..last].iter_mut().enumerate() {
            if actor.at == At::Asleep && place(run, worker).0 == usize::from(phase) {
                actor.at = At::Gate;
            }
        }
    }

    /// What comes after an open gate or a rung bell.
    fn after(run: &Run, actor: &mut Actor, after: After) {
        actor.at = match after {
            After::Await => At::Rings,
            After::Ring => At::Wake,
            After::Next => {
                actor.step += 1;
                if actor.step == run.steps { At::End } else { At::Gate }
            }
        };
    }

    /// No worker may run a step before those that it reads from have, or before it is allowed.
    fn check_order(&self, run: &Run, worker: usize) -> Result<(), String> {
        let (phase, _) = place(run, worker);
        let step = self.actors[worker].step;
        let (conductor, workers) = self.actors.split_last().ok_or("no actors")?;
        if step > conductor.step + run.ahead {
            return Err(format!("step {step} runs while the conductor is at {}", conductor.step));
        }
        for (other, actor) in workers.iter().enumerate() {
            let done = match actor.at {
                At::Gate | At::Sleep(_) | At::Asleep | At::Arrive | At::Died => actor.step,
                _ => actor.step + 1,
            };
            let needed = if place(run, other).0 < phase { step + 1 } else { step };
            if actor.at != At::End && actor.at != At::Died && done < needed {
                return Err(format!("worker {worker} runs step {step} before worker {other} has done {needed} steps"));
            }
        }
        Ok(())
    }

    pub(crate) fn advance(&mut self, run: &Run, index: usize) -> Result<(), String> {
        let flaw = |flaw| run.flaw == Some(flaw);
        let last_phase = run.sizes.len() as u8 - 1;
        let mut actor = self.actors[index].clone();
        let step = actor.step;
        match actor.at {
            At::Gate => {
                let (phase, _) = place(run, index);
                let value = self.gates[phase];
                actor.at = if value & STOP != 0 {
                    At::End
                } else if value == step + 1 {
                    self.check_order(run, index)?;
                    At::Arrive
                } else {
                    At::Sleep(value)
                };
            }
            At::Sleep(value) => {
                let (phase, _) = place(run, index);
                actor.at = if self.gates[phase] == value { At::Asleep } else { At::Gate };
            }
            At::Arrive => {
                let (phase, bit) = place(run, index);
                if self.masks[phase] & bit != 0 {
                    return Err(format!("worker {index} arrives twice"));
                }
                self.masks[phase] |= bit;
                if self.masks[phase] == (1 << run.sizes[phase]) - 1 {
                    actor.at = At::Summary;
                } else {
                    Self::after(run, &mut actor, After::Next);
                }
            }
            At::Summary => {
                let (phase, _) = place(run, index);
                self.full[phase] = true;
                actor.at = match phase as u8 {
                    phase if phase < last_phase => At::ClearSummary(phase + 1, step, After::Next),
                    _ => At::Completed,
                };
            }
            At::Completed => {
                self.completed = step + 1;
                actor.at = At::Limit;
            }
            At::Limit => actor.at = if step + 1 < self.limit { At::Claim(step + 1, After::Ring) } else { At::Wake },
            At::Wake => match self.wake_at == step + 1 {
                true => actor.at = At::Bell(After::Next),
                false => Self::after(run, &mut actor, After::Next),
            },
            At::Claim(step, after) => {
                if self.opened == step || flaw(Flaw::OpenTwice) {
                    self.opened = step + 1;
                    actor.at = At::ClearSummary(0, step, after);
                } else {
                    Self::after(run, &mut actor, after);
                }
            }
            At::ClearSummary(phase, step, after) => {
                if flaw(Flaw::ClearAfterOpening) {
                    self.gates[usize::from(phase)] = step + 1;
                }
                self.full[usize::from(phase)] = false;
                actor.at = At::ClearMask(phase, step, after);
            }
            At::ClearMask(phase, step, after) => {
                self.masks[usize::from(phase)] = 0;
                actor.at = At::ReadGate(phase, step, after);
            }
            At::ReadGate(phase, step, after) => {
                let value = self.gates[usize::from(phase)];
                actor.at = At::SwapGate(phase, step, value, after);
                if value & STOP != 0 {
                    Self::after(run, &mut actor, after);
                }
            }
            At::SwapGate(phase, step, before, after) => {
                if self.gates[usize::from(phase)] == before {
                    self.gates[usize::from(phase)] = step + 1;
                    actor.at = At::WakeGate(phase, step, after);
                } else {
                    Self::after(run, &mut actor, after);
                }
            }
            At::WakeGate(phase, _, after) => {
                self.wake_workers(run, phase);
                Self::after(run, &mut actor, after);
            }
            At::Bell(after) => {
                self.bell += 1;
                actor.at = At::WakeBell(after);
            }
            At::WakeBell(after) => {
                self.wake_conductor();
                Self::after(run, &mut actor, after);
            }
            _ => self.conduct(run, &mut actor),
        }
        self.actors[index] = actor;
        Ok(())
    }

    /// The accesses of the conductor alone.
    fn conduct(&mut self, run: &Run, actor: &mut Actor) {
        let flaw = |flaw| run.flaw == Some(flaw);
        let step = actor.step;
        let enough = (step + 1 + run.ahead / 2).min(run.steps);
        actor.at = match actor.at {
            At::Allow => {
                self.limit = (step + run.ahead + 1).min(run.steps);
                At::Allowed
            }
            At::Allowed if self.completed < self.limit => At::Claim(self.completed, After::Await),
            At::Allowed => At::Rings,
            At::Rings => {
                actor.rings = self.bell;
                At::Interrupted
            }
            At::Interrupted if self.interrupted => At::StopGate(0),
            At::Interrupted => At::Done,
            At::Done if self.completed > step => {
                actor.step += 1;
                if actor.step == run.steps { At::End } else { At::Allow }
            }
            At::Done => At::Dead,
            At::Dead if self.dead => At::StopGate(0),
            At::Dead if flaw(Flaw::LookBeforeAsking) => At::Asked,
            At::Dead => At::Ask,
            At::Ask => {
                self.wake_at = enough;
                if flaw(Flaw::LookBeforeAsking) { At::Rest } else { At::Asked }
            }
            At::Asked if self.completed >= enough => At::Rings,
            At::Asked if flaw(Flaw::LookBeforeAsking) => At::Ask,
            At::Asked => At::Rest,
            At::Rest if self.bell == actor.rings || flaw(Flaw::RingsLast) => At::Asleep,
            At::Rest => At::Rings,
            At::StopGate(phase) => {
                self.gates[usize::from(phase)] |= STOP;
                At::WakeStopped(phase)
            }
            At::WakeStopped(phase) => {
                self.wake_workers(run, phase);
                if usize::from(phase) + 1 < run.sizes.len() { At::StopGate(phase + 1) } else { At::End }
            }
            other => unreachable!("{other:?} is no access of the conductor"),
        };
    }
}
