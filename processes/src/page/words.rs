//! The page as the memory of the protocol.

use std::num::NonZeroU32;
use std::time::Duration;

use rustix::thread::sched_yield;

use super::memory::SharedMemory;
use super::protocol::{Memory, WaitPoint, Word};
use crate::ticks;

// All of it is inlined: an access is one instruction on the word, as if the protocol named the word itself.
impl Memory for SharedMemory {
    #[inline(always)]
    fn phase_count(&self) -> usize {
        self.phases
    }

    #[inline(always)]
    fn worker_count(&self) -> usize {
        self.workers
    }

    #[inline(always)]
    fn member_count(&self, phase: usize) -> usize {
        self.members[phase] as usize
    }

    #[inline(always)]
    fn limit(&self) -> impl Word<u64> {
        &self.head().progress.limit
    }

    #[inline(always)]
    fn completed(&self) -> impl Word<u64> {
        &self.head().progress.completed
    }

    #[inline(always)]
    fn wake_at(&self) -> impl Word<u64> {
        &self.head().progress.wake_at
    }

    #[inline(always)]
    fn completion_claim(&self) -> impl Word<u64> {
        &self.head().progress.completion_claim
    }

    #[inline(always)]
    fn bell(&self) -> impl Word<u32> {
        &self.head().bell
    }

    #[inline(always)]
    fn gate(&self, phase: usize) -> impl Word<u32> {
        &self.phase(phase).gate
    }

    #[inline(always)]
    fn gate_claim(&self, phase: usize) -> impl Word<u64> {
        &self.phase(phase).claim
    }

    #[inline(always)]
    fn arrivals(&self, phase: usize, word: usize) -> impl Word<u64> {
        &self.phase(phase).arrivals[word]
    }

    #[inline(always)]
    fn opened_at(&self, phase: usize) -> impl Word<u64> {
        &self.phase(phase).opened_at
    }

    #[inline(always)]
    fn group_members(&self, phase: usize, group: usize) -> impl Word<u32> {
        &self.phase(phase).groups[group].count
    }

    #[inline(always)]
    fn group_arrivals(&self, phase: usize, group: usize) -> impl Word<u32> {
        &self.phase(phase).groups[group].arrived
    }

    #[inline(always)]
    fn polled(&self, group: usize) -> impl Word<u64> {
        &self.head().groups[group].polled
    }

    #[inline(always)]
    fn polling_limit(&self) -> impl Word<u64> {
        &self.head().settings.polling_limit
    }

    #[inline(always)]
    fn group(&self, worker: usize) -> impl Word<u32> {
        &self.slot(worker).group
    }

    #[inline(always)]
    fn dismissed(&self, worker: usize) -> impl Word<u32> {
        &self.slot(worker).dismissed
    }

    #[inline(always)]
    fn yield_limit(&self) -> impl Word<u64> {
        &self.head().settings.yield_limit
    }

    #[inline(always)]
    fn now(&self) -> u64 {
        ticks::now()
    }

    #[inline(always)]
    fn yield_core(&self) {
        sched_yield();
    }

    #[inline(always)]
    fn sleep_while(&self, point: WaitPoint, value: u32, groups: NonZeroU32, patience: Option<Duration>) {
        self.waker.sleep_while(self.wait_word(point), point, value, groups, patience);
    }

    #[inline(always)]
    fn wake(&self, point: WaitPoint, groups: u32) {
        self.waker.wake(self.wait_word(point), point, groups);
    }

    #[inline(always)]
    fn wakes_groups(&self) -> bool {
        self.waker.wakes_groups()
    }
}
