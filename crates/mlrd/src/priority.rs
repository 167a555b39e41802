//! Priority of single threads.

use rustix::{io, process::setpriority_process, thread::gettid};

/// What gives way to everything else.
const NICEST: i32 = 19;

/// Lets the calling thread, and no other, give way to all others: Linux keeps niceness
/// by thread.
///
/// # Errors
/// When the system refuses.
pub(crate) fn lower_this_thread() -> io::Result<()> {
    setpriority_process(Some(gettid()), NICEST)
}

#[cfg(test)]
mod tests {
    use std::thread;

    use rustix::process::getpriority_process;

    use super::*;

    #[test]
    fn one_thread_gives_way_and_the_others_do_not() {
        let before = getpriority_process(Some(gettid())).unwrap();
        let lowered = thread::spawn(|| {
            lower_this_thread().unwrap();
            getpriority_process(Some(gettid())).unwrap()
        });
        assert_eq!(lowered.join().unwrap(), NICEST);
        assert_eq!(getpriority_process(Some(gettid())).unwrap(), before);
    }
}
