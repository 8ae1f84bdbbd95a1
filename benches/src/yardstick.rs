//! The yardstick: the same number of processes in the same phases, raw futexes on a shared page, no sample, no bookkeeping.

use std::env;
use std::fs::{File, OpenOptions};
use std::io;
use std::os::fd::AsRawFd;
use std::process::{Child, Command};
use std::sync::atomic::{AtomicU32, Ordering::SeqCst};
use std::time::Instant;

use rustix::fs::MemfdFlags;
use rustix::mm::{MapFlags, ProtFlags};
use rustix::process::Signal;
use rustix::thread::futex;

/// Environment variable that makes this program a process of the yardstick: page, phase, size of the phase, steps.
const PLACE: &str = "YARDSTICK";
/// Most phases of a step.
const PHASES: usize = 8;

#[repr(C, align(128))]
struct Word(AtomicU32);

#[repr(C)]
struct Page {
    done: Word,
    gates: [Word; PHASES],
    arrived: [Word; PHASES],
}

impl Word {
    fn publish(&self, value: u32) {
        self.0.store(value, SeqCst);
        let _ = futex::wake(&self.0, futex::Flags::empty(), i32::MAX as u32);
    }

    fn reach(&self, value: u32) {
        loop {
            let now = self.0.load(SeqCst);
            if now.wrapping_sub(value) as i32 >= 0 {
                return;
            }
            let _ = futex::wait(&self.0, futex::Flags::empty(), now, None);
        }
    }
}

/// Seconds per step of `steps` steps through phases of these sizes, the starter in the loop between all of them.
pub(crate) fn measure(sizes: &[usize], steps: u32) -> io::Result<f64> {
    // Inherited by the children, hence without CLOEXEC.
    let file = rustix::fs::memfd_create("yardstick", MemfdFlags::empty())?;
    rustix::fs::ftruncate(&file, size_of::<Page>() as u64)?;
    let file = File::from(file);
    let page = map(&file)?;
    let mut children: Vec<Child> = Vec::new();
    for (phase, size) in sizes.iter().enumerate() {
        for _ in 0..*size {
            let place = format!("{} {phase} {size} {steps}", file.as_raw_fd());
            children.push(Command::new(env::current_exe()?).env(PLACE, place).spawn()?);
        }
    }
    // The first step is the start of the processes.
    let mut start = Instant::now();
    for step in 1..=steps {
        for phase in 0..sizes.len() {
            page.gates[phase].publish(step);
            page.done.reach((step - 1) * sizes.len() as u32 + phase as u32 + 1);
        }
        if step == 1 {
            start = Instant::now();
        }
    }
    let elapsed = start.elapsed().as_secs_f64();
    for mut child in children {
        child.wait()?;
    }
    Ok(elapsed / f64::from(steps - 1))
}

/// Whether this process belongs to a yardstick; it has done its part then.
pub(crate) fn serve() -> io::Result<bool> {
    let Ok(place) = env::var(PLACE) else { return Ok(false) };
    rustix::process::set_parent_process_death_signal(Some(Signal::KILL))?;
    let numbers: Vec<u32> = place.split(' ').filter_map(|word| word.parse().ok()).collect();
    let [file, phase, size, steps] = numbers[..] else {
        return Err(io::Error::other(format!("{PLACE} is not four numbers")));
    };
    let page = map(&OpenOptions::new().read(true).write(true).open(format!("/proc/self/fd/{file}"))?)?;
    let phase = phase as usize;
    for step in 1..=steps {
        page.gates[phase].reach(step);
        if page.arrived[phase].0.fetch_add(1, SeqCst) + 1 == size * step {
            page.done.publish(page.done.0.load(SeqCst) + 1);
        }
    }
    Ok(true)
}

/// The page; it stays mapped until the process ends.
fn map(file: &File) -> io::Result<&'static Page> {
    let flags = MapFlags::SHARED | MapFlags::POPULATE;
    // SAFETY: a new mapping of a file that was made as long as the page; it is never unmapped, and consists of atomics only,
    // for which the zeros of a new file are valid.
    unsafe {
        let address = rustix::mm::mmap(
            std::ptr::null_mut(),
            size_of::<Page>(),
            ProtFlags::READ | ProtFlags::WRITE,
            flags,
            file,
            0,
        )?;
        Ok(&*address.cast::<Page>())
    }
}
