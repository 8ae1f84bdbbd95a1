//! What happens when shared memory of a run is cut short while this process uses it.
//!
//! The kernel then answers every touch of what is missing with SIGBUS. Here, a page of zeros takes the place of what is missing,
//! and the conductor finds out after the step: no sample of zeros has a valid seal.

use std::mem::MaybeUninit;
use std::sync::Once;

use rustix::fs::{Mode, OFlags};
use rustix::mm::{MapFlags, ProtFlags};

/// What the files begin with that this is for.
const FILES: &[u8] = b"/dev/shm/phalanx";
/// Bytes of `/proc/self/maps` that are looked at together; longer than any line.
const PIECE: usize = 2048;

static INSTALL: Once = Once::new();
static mut BEFORE: MaybeUninit<libc::sigaction> = MaybeUninit::uninit();

/// From now on, memory of runs that is missing reads as zeros.
pub(crate) fn stand_in_for_missing_memory() {
    INSTALL.call_once(|| {
        // Found out now, since the handler must not.
        let _ = rustix::param::page_size();
        // SAFETY: `action` is whole; the handler makes system calls only. `BEFORE` is written here, once, before anything can
        // read it.
        unsafe {
            let mut action: libc::sigaction = std::mem::zeroed();
            action.sa_sigaction = handle as *const () as usize;
            action.sa_flags = libc::SA_SIGINFO;
            libc::sigaction(libc::SIGBUS, &action, (&raw mut BEFORE).cast());
        }
    });
}

extern "C" fn handle(_: libc::c_int, info: *mut libc::siginfo_t, _: *mut libc::c_void) {
    // SAFETY: the kernel passes a valid description of a fault.
    let address = unsafe { (*info).si_addr() } as usize;
    if is_of_a_run(address) && replace_page(address) {
        return;
    }
    // The instruction is tried again, and then belongs to who handled it before.
    // SAFETY: written before this handler was installed.
    unsafe { libc::sigaction(libc::SIGBUS, (&raw const BEFORE).cast(), std::ptr::null_mut()) };
}

/// Whether a file of a run is mapped at an address.
fn is_of_a_run(address: usize) -> bool {
    let Ok(maps) = rustix::fs::open(c"/proc/self/maps", OFlags::RDONLY | OFlags::CLOEXEC, Mode::empty()) else {
        return false;
    };
    let mut piece = [0; PIECE];
    let mut filled = 0;
    loop {
        let Ok(count @ 1..) = rustix::io::read(&maps, &mut piece[filled..]) else { return false };
        filled += count;
        while let Some(end) = piece[..filled].iter().position(|&byte| byte == b'\n') {
            if maps_run(&piece[..end], address) {
                return true;
            }
            piece.copy_within(end + 1..filled, 0);
            filled -= end + 1;
        }
        if filled == PIECE {
            return false;
        }
    }
}

/// Whether a line of `/proc/self/maps` is about a file of a run at an address.
fn maps_run(line: &[u8], address: usize) -> bool {
    let mut words = line.split(|&byte| byte == b' ').filter(|word| !word.is_empty());
    let range = words.next().and_then(|range| std::str::from_utf8(range).ok()?.split_once('-'));
    let number = |text| usize::from_str_radix(text, 16).ok();
    let Some((start, end)) = range.and_then(|(start, end)| Some((number(start)?, number(end)?))) else { return false };
    (start..end).contains(&address) && words.nth(4).is_some_and(|path| path.starts_with(FILES))
}

/// Maps a page of zeros at an address.
fn replace_page(address: usize) -> bool {
    let size = rustix::param::page_size();
    let page = (address & !(size - 1)) as *mut _;
    // SAFETY: the page belongs to a mapping of a file that is not there any more; references to it read zeros.
    let mapped = unsafe {
        rustix::mm::mmap_anonymous(page, size, ProtFlags::READ | ProtFlags::WRITE, MapFlags::PRIVATE | MapFlags::FIXED)
    };
    mapped.is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::OpenOptions;

    #[test]
    fn missing_memory_reads_as_zeros() {
        let path = format!("/dev/shm/phalanx-bus-test-{}", std::process::id());
        let file = OpenOptions::new().read(true).write(true).create_new(true).open(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        file.set_len(8192).unwrap();
        let (flags, access) = (MapFlags::SHARED, ProtFlags::READ | ProtFlags::WRITE);
        // SAFETY: a new mapping of a file of this size.
        let base = unsafe { rustix::mm::mmap(std::ptr::null_mut(), 8192, access, flags, &file, 0) }.unwrap();
        let second = base.cast::<u8>().wrapping_add(5000);
        // SAFETY: within the mapping.
        unsafe { second.write_volatile(7) };
        stand_in_for_missing_memory();
        file.set_len(0).unwrap();
        // SAFETY: within the mapping; what is missing of its file is replaced.
        assert_eq!(unsafe { second.read_volatile() }, 0);
    }

    #[test]
    fn only_files_of_runs_count() {
        let line =
            b"7f0000000000-7f0000002000 rw-s 00000000 00:1a 12                         /dev/shm/phalanx0-uav_1.x";
        assert!(maps_run(line, 0x7f0000001fff) && !maps_run(line, 0x7f0000002000));
        assert!(!maps_run(b"7f0000000000-7f0000002000 rw-s 00000000 00:1a 12   /home/log.mcap", 0x7f0000000000));
        assert!(!maps_run(b"7f0000000000-7f0000002000 rw-p 00000000 00:00 0 ", 0x7f0000000000));
    }
}
