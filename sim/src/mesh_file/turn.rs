//! How many meshes that take much memory are read at a time.

use std::sync::{Condvar, Mutex, PoisonError};

/// What any mesh may take while it is read, bytes: textures of 4096 pixels a side among it. A hostile one takes ten times as much.
pub(super) const LIGHT: u64 = 128 << 20;
/// Meshes that take more, read at a time by the whole process.
const AT_A_TIME: usize = 4;

static FREE: Mutex<usize> = Mutex::new(AT_A_TIME);
static FREED: Condvar = Condvar::new();

/// The right to take more, until it is dropped. Who has one must wait for nothing that another with a turn may hold.
pub(super) struct Turn(());

impl Turn {
    /// Waits for one.
    pub fn wait() -> Self {
        let free = FREE.lock().unwrap_or_else(PoisonError::into_inner);
        let mut free = FREED.wait_while(free, |free| *free == 0).unwrap_or_else(PoisonError::into_inner);
        *free -= 1;
        Self(())
    }
}

impl Drop for Turn {
    fn drop(&mut self) {
        *FREE.lock().unwrap_or_else(PoisonError::into_inner) += 1;
        FREED.notify_one();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::thread;

    #[test]
    fn no_more_have_a_turn_than_there_are() {
        let (having, most) = (AtomicUsize::new(0), AtomicUsize::new(0));
        thread::scope(|scope| {
            for _ in 0..3 * AT_A_TIME {
                scope.spawn(|| {
                    let _turn = Turn::wait();
                    most.fetch_max(having.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
                    thread::yield_now();
                    having.fetch_sub(1, Ordering::SeqCst);
                });
            }
        });
        assert!((1..=AT_A_TIME).contains(&most.into_inner()));
    }
}
