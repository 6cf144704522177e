//! The last wall before a runtime that was written for models one trusts.

use std::any::Any;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, PanicHookInfo, catch_unwind, set_hook, take_hook};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tract_onnx::prelude::TractResult;

type Hook = Box<dyn Fn(&PanicHookInfo<'_>) + Sync + Send>;

/// The result of work that may panic.
pub(super) fn contained<T>(work: impl FnOnce() -> TractResult<T>) -> Result<T, String> {
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(result) => result.map_err(|error| format!("{error:#}")),
        Err(payload) => Err(format!("it panicked: {}", message(&*payload))),
    }
}

/// [`contained`], and nothing is printed where the work panics; what other threads panic with is.
pub(super) fn contained_in_silence<T>(work: impl FnOnce() -> TractResult<T>) -> Result<T, String> {
    let _silence = Silence::begin();
    contained(work)
}

fn message(payload: &(dyn Any + Send)) -> &str {
    let text = payload.downcast_ref::<&str>().copied();
    text.or_else(|| payload.downcast_ref::<String>().map(String::as_str)).unwrap_or("without a message")
}

thread_local! {
    /// Whether this thread's panics are not to be printed.
    static SILENT: Cell<bool> = const { Cell::new(false) };
}

/// Threads in silence, and the hook that is put back when the last one leaves.
struct Waiting {
    threads: usize,
    hook: Option<Arc<Hook>>,
    /// Where the hook lies that is in its place.
    ours: usize,
}

static WAITING: Mutex<Waiting> = Mutex::new(Waiting { threads: 0, hook: None, ours: 0 });

/// Keeps a thread's panics from being printed as long as it lives.
struct Silence(bool);

impl Silence {
    fn begin() -> Self {
        // The hook cannot be changed by a thread that is panicking, nor need it be by one that is silent.
        if std::thread::panicking() || SILENT.replace(true) {
            return Self(false);
        }
        let mut waiting = waiting();
        waiting.threads += 1;
        if waiting.threads == 1 {
            let hook = Arc::new(take_hook());
            waiting.hook = Some(Arc::clone(&hook));
            let ours: Hook = Box::new(move |info| {
                if !SILENT.get() {
                    hook(info);
                }
            });
            waiting.ours = place(&ours);
            set_hook(ours);
        }
        Self(true)
    }
}

impl Drop for Silence {
    fn drop(&mut self) {
        if !self.0 {
            return;
        }
        SILENT.set(false);
        let mut waiting = waiting();
        waiting.threads -= 1;
        if waiting.threads > 0 {
            return;
        }
        let (present, before) = (take_hook(), waiting.hook.take());
        if place(&present) != waiting.ours {
            // Somebody else's, from whom it is not taken.
            return set_hook(present);
        }
        drop(present);
        if let Some(Ok(hook)) = before.map(Arc::try_unwrap) {
            set_hook(hook);
        }
    }
}

fn waiting() -> MutexGuard<'static, Waiting> {
    WAITING.lock().unwrap_or_else(PoisonError::into_inner)
}

fn place(hook: &Hook) -> usize {
    std::ptr::from_ref(&**hook).cast::<()>().addr()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::Command;
    use std::sync::Barrier;

    #[test]
    fn a_panic_is_told_and_an_error_too() {
        let told = contained_in_silence::<()>(|| panic!("axis {}", 7)).unwrap_err();
        assert_eq!(told, "it panicked: axis 7");
        assert_eq!(contained(|| Ok(3)), Ok(3));
        assert_eq!(contained::<()>(|| Err(std::fmt::Error.into())), Err(std::fmt::Error.to_string()));
    }

    /// In a process of its own, since hooks and standard error are the process's.
    #[test]
    fn only_panics_in_silence_are_not_printed_and_the_hook_is_put_back() {
        let test = "onnx::contained::tests::panics_of_some_threads";
        let mut command = Command::new(std::env::current_exe().unwrap());
        let ran = command.args(["--exact", test, "--ignored", "--nocapture"]).output().unwrap();
        let printed = String::from_utf8(ran.stderr).unwrap();
        assert!(ran.status.success(), "{printed}");
        for (number, expected) in [("first", false), ("second", true), ("third", false), ("fourth", true)] {
            assert_eq!(printed.contains(number), expected, "{number}: {printed}");
        }
        assert_eq!(printed.matches("by the own hook").count(), 2, "{printed}");
    }

    #[test]
    #[ignore = "prints panics for another test"]
    fn panics_of_some_threads() {
        set_hook(Box::new(|info| {
            let text = message(info.payload());
            eprintln!("{text} by the own hook");
        }));
        let both = Barrier::new(2);
        std::thread::scope(|scope| {
            scope.spawn(|| {
                let told = contained_in_silence::<()>(|| {
                    both.wait();
                    both.wait();
                    panic!("first")
                });
                assert!(told.is_err());
            });
            both.wait();
            assert!(contained::<()>(|| panic!("second")).is_err());
            assert!(contained_in_silence::<()>(|| panic!("third")).is_err());
            both.wait();
        });
        assert!(contained::<()>(|| panic!("fourth")).is_err());
    }
}
