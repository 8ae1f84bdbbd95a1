//! Panics of participants, turned into words for the conductor.

use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, PanicHookInfo, catch_unwind, set_hook, take_hook};
use std::thread;

thread_local! {
    static LAST: RefCell<String> = const { RefCell::new(String::new()) };
}

/// From now on, panics of the calling thread are kept for [`catch`] instead of being printed.
pub(super) fn remember_those_of_this_thread() {
    let serving = thread::current().id();
    let print = take_hook();
    set_hook(Box::new(move |panic| {
        if thread::current().id() == serving {
            LAST.set(describe(panic));
        } else {
            print(panic);
        }
    }));
}

/// Does `work`; a panic becomes an error that says what and where.
pub(super) fn catch<R>(work: impl FnOnce() -> R) -> Result<R, String> {
    // Whatever the panic left half-done is not used again: the process ends with the report.
    catch_unwind(AssertUnwindSafe(work)).map_err(|_| LAST.take())
}

fn describe(panic: &PanicHookInfo) -> String {
    let payload = panic.payload();
    let text = payload.downcast_ref::<&str>().copied().or(payload.downcast_ref::<String>().map(String::as_str));
    let place = panic.location().map(|place| format!(" at {place}")).unwrap_or_default();
    format!("panicked{place}: {}", text.unwrap_or("without a message"))
}
