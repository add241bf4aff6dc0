//! Early end of a kernel, for example after Ctrl-C.
//!
//! Kernels call [`check`] between pieces of work of some milliseconds at most. After a request to stop,
//! it unwinds through the threads of rayon to the caller of the kernel. So a kernel needs no second kind of result.
//! It leaves nothing half done, because it owns all that it changes.

use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, Ordering};

static IS_REQUESTED: AtomicBool = AtomicBool::new(false);

/// Payload with which [`check`] unwinds.
#[derive(Clone, Copy, Debug)]
pub struct Interruption;

/// Request that all running kernels stop.
pub fn request() {
    IS_REQUESTED.store(true, Ordering::Relaxed);
}

/// Let kernels run again.
pub fn clear() {
    IS_REQUESTED.store(false, Ordering::Relaxed);
}

/// The fewest items of one task of rayon, for `items` that each call [`check`]: every task unwinds by itself, and takes
/// some microseconds for it.
pub fn min_task_len(items: usize) -> usize {
    const MOST_TASKS: usize = 256;
    items.div_ceil(MOST_TASKS).max(1)
}

/// Unwind with [`Interruption`] if a stop is requested.
#[inline]
pub fn check() {
    if IS_REQUESTED.load(Ordering::Relaxed) {
        // Without the message that a panic prints: nothing is wrong.
        resume_unwind(Box::new(Interruption));
    }
}
