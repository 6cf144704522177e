//! The widest vector instructions that the CPU has.

use pulp::{Arch, Simd, WithSimd};

/// Does work that is marked `#[inline(always)]`, and all it calls that is, compiled for the CPU's vector instructions.
///
/// The bits of the results stay the same: the compiler never fuses a multiplication with an addition by itself.
pub fn widest<T>(work: impl FnMut() -> T) -> T {
    Arch::new().dispatch(Work(work))
}

struct Work<F>(F);

impl<T, F: FnMut() -> T> WithSimd for Work<F> {
    type Output = T;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, _: S) -> T {
        (self.0)()
    }
}
