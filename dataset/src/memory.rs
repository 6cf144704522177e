//! Memory that work takes and frees again and again.

use std::sync::Once;

/// Just below `DEFAULT_MMAP_THRESHOLD_MAX` of 64-bit glibc, 32 MiB; larger blocks leave its thresholds alone.
const BLOCK: usize = 31 << 20;

static KEPT: Once = Once::new();

/// Lets the whole process keep more of the memory that it frees, some tens of megabytes: called before work that takes and frees megabytes
/// at every step.
///
/// Freeing a mapped block raises glibc's `M_MMAP_THRESHOLD` to its size, and `M_TRIM_THRESHOLD` to twice that (mallopt(3)). What is
/// freed then stays in the process, where it would be unmapped and faulted in again, page by page. Without effect under other
/// allocators, such as that of `bench`, on 32 bits, or where the environment sets one of the thresholds.
pub fn keep_freed() {
    // Only the first block is mapped: later ones would come from the memory that is kept, and be cleared.
    KEPT.call_once(|| drop(std::hint::black_box(vec![0_u8; BLOCK])));
}
