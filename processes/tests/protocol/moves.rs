//! The accesses themselves, each in one indivisible move.

use crate::model::{Actor, After, At, Flaw, Ordeal, Run, State};

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

/// The side of a worker; there is only one if nobody watches.
fn side(run: &Run, worker: usize) -> usize {
    run.sides.get(worker).map_or(0, |&side| side.into())
}

/// All sides, as bits.
const EVERYBODY: u8 = u8::MAX;

/// The gate that a worker watches after it has done `step - 1`: the next one at which its side has workers.
fn target(run: &Run, worker: usize, step: u8) -> (usize, u8) {
    let (own, _) = place(run, worker);
    let workers: usize = run.sizes.iter().map(|&size| usize::from(size)).sum();
    let has_workers =
        |phase: usize| (0..workers).any(|other| side(run, other) == side(run, worker) && place(run, other).0 == phase);
    let behind = (own + 1..run.sizes.len()).find(|&phase| has_workers(phase)).map(|phase| (phase, step - 1));
    behind.or_else(|| (0..=own).find(|&phase| has_workers(phase)).map(|phase| (phase, step))).unwrap_or((own, step))
}

impl State {
    pub(crate) fn wake_conductor(&mut self) {
        if let Some(conductor) = self.actors.last_mut().filter(|conductor| conductor.at == At::Asleep) {
            conductor.at = At::Rings;
        }
    }

    fn wake_workers(&mut self, run: &Run, phase: u8, sides: u8) {
        let last = self.actors.len() - 1;
        for (worker, actor) in self.actors[..last].iter_mut().enumerate() {
            let is_meant = place(run, worker).0 == usize::from(phase) && sides & 1 << side(run, worker) != 0;
            if actor.at == At::Asleep && is_meant {
                actor.at = At::Gate;
            }
        }
    }

    /// What comes after an open gate or a rung bell.
    fn after(run: &Run, actor: &mut Actor, after: After) {
        actor.at = match after {
            After::Await => At::Rings,
            After::Opened(phase, step) => At::RepairOpened(phase, step),
            After::Behind(phase, step) if usize::from(phase) + 1 < run.sizes.len() => At::RepairGate(phase + 1, step),
            After::Behind(_, step) => At::RepairFinish(step),
            After::Ring => At::Wake,
            After::Next => {
                actor.step += 1;
                match actor.step == run.steps {
                    true => At::End,
                    false if run.sides.is_empty() => At::Gate,
                    false => At::MayWatch,
                }
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
                At::MayWatch | At::Watch | At::Watching | At::LookAgain | At::LookedBefore(_) | At::WakeSide => {
                    actor.step
                }
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
        let finish = run.sizes.len() as u8;
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
                    actor.at = At::Claim(phase as u8 + 1, step, After::Next);
                } else {
                    Self::after(run, &mut actor, After::Next);
                }
            }
            At::Wake => match self.wake_at == step + 1 {
                true => actor.at = At::Bell(After::Next),
                false => Self::after(run, &mut actor, After::Next),
            },
            At::Claim(target, step, after) => match self.claims[usize::from(target)].0 {
                steps if steps <= step => actor.at = At::TakeClaim(target, step, steps, after),
                _ if flaw(Flaw::OpenTwice) && target == 0 => actor.at = At::ClearMask(target, step, after),
                _ => Self::after(run, &mut actor, after),
            },
            At::TakeClaim(target, step, before, after) => {
                let claim = &mut self.claims[usize::from(target)];
                if claim.0 == before || flaw(Flaw::OpenTwice) {
                    *claim = (step + 1, index as u8);
                    actor.at =
                        if target == finish { At::Completed(step, after) } else { At::ClearMask(target, step, after) };
                } else {
                    Self::after(run, &mut actor, after);
                }
            }
            At::Completed(step, after) => {
                self.completed = step + 1;
                actor.at = At::Limit(step, after);
            }
            At::Limit(step, after) => {
                // Whoever completes a step looks afterwards whether the conductor is waiting; the conductor is not.
                let after = if after == After::Next { After::Ring } else { after };
                if step + 1 < self.limit {
                    actor.at = At::Claim(0, step + 1, after);
                } else {
                    Self::after(run, &mut actor, after);
                }
            }
            At::ClearMask(phase, step, after) => {
                if flaw(Flaw::ClearAfterOpening) {
                    self.gates[usize::from(phase)] = step + 1;
                    actor.at = At::WakeGate(phase, step, after);
                } else {
                    self.masks[usize::from(phase)] = 0;
                    actor.at = At::ReadGate(phase, step, after);
                }
            }
            At::ReadGate(phase, step, after) => {
                let value = self.gates[usize::from(phase)];
                if flaw(Flaw::LookBeforeOpening) {
                    let unwatched = |side: &usize| self.watched[*side] != (phase + 1, step + 1);
                    let own = if index + 1 < self.actors.len() { 1 << side(run, index) } else { 0 };
                    actor.rings = (0..2).filter(unwatched).fold(own, |bits, side| bits | 1 << side);
                }
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
                if flaw(Flaw::ClearAfterOpening) {
                    self.masks[usize::from(phase)] = 0;
                }
                if run.sides.is_empty() {
                    self.wake_workers(run, phase, EVERYBODY);
                    Self::after(run, &mut actor, after);
                } else if flaw(Flaw::LookBeforeOpening) {
                    self.wake_workers(run, phase, actor.rings);
                    Self::after(run, &mut actor, after);
                } else {
                    actor.at = At::Watched(phase, step, 0, 0, after);
                }
            }
            At::Watched(phase, opened, number, bits, after) if usize::from(number) < self.watched.len() => {
                let is_own = index + 1 < self.actors.len() && side(run, index) == usize::from(number);
                let watched = self.watched[usize::from(number)];
                let is_relied_on = watched == (phase + 1, opened + 1) || flaw(Flaw::AnyWatcher) && watched.0 != 0;
                let is_woken = is_own || !is_relied_on;
                let bits = bits | u8::from(is_woken) << number;
                actor.at = At::Watched(phase, opened, number + 1, bits, after);
            }
            At::Watched(phase, _, _, bits, after) => {
                self.wake_workers(run, phase, bits);
                Self::after(run, &mut actor, after);
            }
            At::MayWatch => actor.at = At::Watch,
            At::Watch => {
                let (phase, at) = target(run, index, step);
                let watched = &mut self.watched[side(run, index)];
                let is_free = watched.0 == 0;
                if is_free {
                    *watched = (phase as u8 + 1, at + 1);
                }
                actor.at = if is_free { At::Watching } else { At::Gate };
            }
            At::Watching if flaw(Flaw::LookBeforeLeaving) => {
                let (phase, at) = target(run, index, step);
                let value = self.gates[phase];
                actor.at = At::LookedBefore(value & STOP != 0 || value == at + 1);
            }
            At::LookedBefore(open) => {
                self.watched[side(run, index)] = (0, 0);
                actor.at = if open { At::WakeSide } else { At::Gate };
            }
            // However often it has looked: the watch ends at some time.
            At::Watching => {
                self.watched[side(run, index)] = (0, 0);
                actor.at = At::LookAgain;
            }
            At::LookAgain => {
                let (phase, at) = target(run, index, step);
                let value = self.gates[phase];
                actor.at = if value & STOP != 0 || value == at + 1 { At::WakeSide } else { At::Gate };
            }
            At::WakeSide => {
                let (phase, _) = target(run, index, step);
                self.wake_workers(run, phase as u8, 1 << side(run, index));
                actor.at = At::Gate;
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
            At::Allowed if self.completed < self.limit => At::Claim(0, self.completed, After::Await),
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
            At::Dead if self.dead && run.ordeal == Ordeal::Replacement && flaw(Flaw::NoRepair) => At::Resume,
            At::Dead if self.dead && run.ordeal == Ordeal::Replacement => {
                if run.sides.is_empty() || flaw(Flaw::NoRelief) { At::Repair } else { At::Relieve(0) }
            }
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
                self.wake_workers(run, phase, EVERYBODY);
                if usize::from(phase) + 1 < run.sizes.len() { At::StopGate(phase + 1) } else { At::End }
            }
            _ => return self.repair(run, actor),
        };
    }

    /// The accesses of the conductor when a worker has died and another one takes its place.
    fn repair(&mut self, run: &Run, actor: &mut Actor) {
        let workers = self.actors.len() - 1;
        let dead = self.actors[..workers].iter().position(|actor| actor.at == At::Died).unwrap_or(workers);
        let finish = run.sizes.len();
        let is_open = |phase: u8, step: u8| self.gates[usize::from(phase)] == step + 1;
        let left_by_the_dead = |target: usize, step: u8| self.claims[target] == (step + 1, dead as u8);
        actor.at = match actor.at {
            At::Relieve(number) if usize::from(number) < self.watched.len() => {
                self.watched[usize::from(number)] = (0, 0);
                At::Relieve(number + 1)
            }
            At::Relieve(_) => At::WakeRelieved(0),
            At::WakeRelieved(phase) if usize::from(phase) < run.sizes.len() => {
                self.wake_workers(run, phase, EVERYBODY);
                At::WakeRelieved(phase + 1)
            }
            At::WakeRelieved(_) => At::Repair,
            At::Repair => At::RepairGate(0, self.completed),
            At::RepairGate(phase, step) if is_open(phase, step) => At::RepairWake(phase, step),
            At::RepairGate(phase, step) => At::RepairClaim(phase, step),
            At::RepairClaim(phase, step) if left_by_the_dead(phase.into(), step) => {
                At::ClearMask(phase, step, After::Opened(phase, step))
            }
            At::RepairClaim(0, step) => At::RepairLimit(0, step),
            At::RepairClaim(phase, step) => At::RepairOpened(phase, step),
            At::RepairLimit(phase, step) if step < self.limit => At::Claim(0, step, After::Opened(phase, step)),
            At::RepairLimit(phase, step) => At::RepairOpened(phase, step),
            At::RepairOpened(phase, step) if is_open(phase, step) => At::RepairWake(phase, step),
            At::RepairOpened(..) => At::Resume,
            At::RepairWake(phase, step) => {
                self.wake_workers(run, phase, EVERYBODY);
                At::RepairStillOpen(phase, step)
            }
            At::RepairStillOpen(phase, step) if is_open(phase, step) => At::RepairMask(phase, step),
            At::RepairStillOpen(..) => At::Resume,
            At::RepairMask(phase, step)
                if self.masks[usize::from(phase)] == (1 << run.sizes[usize::from(phase)]) - 1 =>
            {
                let target = phase + 1;
                match run.flaw {
                    Some(Flaw::RepairUnclaimed) if usize::from(target) < finish => {
                        At::ClearMask(target, step, After::Behind(phase, step))
                    }
                    _ => At::Claim(target, step, After::Behind(phase, step)),
                }
            }
            At::RepairMask(..) => At::Resume,
            At::RepairFinish(step) if left_by_the_dead(finish, step) => At::RepairCompleted(step),
            At::RepairFinish(_) => At::Resume,
            At::RepairCompleted(step) if self.completed == step => {
                At::Completed(step, After::Behind(finish as u8 - 1, step))
            }
            At::RepairCompleted(_) => At::Resume,
            At::Resume => At::ResumeGate(self.completed),
            At::ResumeGate(step) if dead == workers || !is_open(place(run, dead).0 as u8, step) => {
                At::ResumeAgain(step, 0)
            }
            At::ResumeGate(step) => At::ResumeMask(step),
            At::ResumeMask(step) => {
                let (phase, bit) = place(run, dead);
                At::ResumeAgain(step, u8::from(self.masks[phase] & bit != 0))
            }
            At::ResumeAgain(step, _) if self.completed != step => At::Resume,
            At::ResumeAgain(step, arrived) => {
                if let Some(worker) = self.actors[..workers].get_mut(dead) {
                    worker.step = step + arrived;
                    worker.at = if worker.step == run.steps { At::End } else { At::Gate };
                }
                self.dead = false;
                At::Rings
            }
            other => unreachable!("{other:?} is no access of the conductor"),
        };
    }
}
