//! What happens when nobody reads any more.

/// When whoever reads what is printed has gone, as `head` does, the program ends without a word, like any other.
pub(super) fn end_with_the_reader() {
    /// 128 and the number of SIGPIPE, as a shell reports it of a program that does not ignore that signal.
    const READER_GONE: i32 = 141;
    let report = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        let text = panic.payload().downcast_ref::<String>();
        if text.is_some_and(|text| text.contains("os error 32") || text.contains("BrokenPipe")) {
            std::process::exit(READER_GONE);
        }
        report(panic);
    }));
}
