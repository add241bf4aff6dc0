//! A caller who wants the answer no more, as by Ctrl-C.
//!
//! Kernels call [`check`] between pieces of work of some milliseconds at most. Once the caller has asked, it unwinds
//! from there, through the threads of rayon too, up to whoever runs the kernel. So a kernel needs no second kind of
//! result for it, and leaves nothing half done, for it owns all that it changes.

use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, Ordering};

static ASKED: AtomicBool = AtomicBool::new(false);

/// What [`check`] unwinds with.
#[derive(Clone, Copy, Debug)]
pub struct Interrupted;

/// Ask all kernels that run to stop.
pub fn ask() {
    ASKED.store(true, Ordering::Relaxed);
}

/// Let kernels run again.
pub fn clear() {
    ASKED.store(false, Ordering::Relaxed);
}

/// The fewest items of one task of rayon, for `items` that each call [`check`]: every task unwinds by itself, and takes
/// some microseconds for it.
pub fn min_task_len(items: usize) -> usize {
    const MOST_TASKS: usize = 256;
    items.div_ceil(MOST_TASKS).max(1)
}

/// Unwind with [`Interrupted`] if a caller has asked to stop.
#[inline]
pub fn check() {
    if ASKED.load(Ordering::Relaxed) {
        // Without the message that a panic prints: nothing is wrong.
        resume_unwind(Box::new(Interrupted));
    }
}
