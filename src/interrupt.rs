//! Interruption of a running kernel, for example by Ctrl-C.
//!
//! Kernels call [`check`] between pieces of work that take a few milliseconds. After a request to stop, it unwinds
//! through the threads of rayon up to the binding that runs the kernel. A kernel owns everything that it changes, so
//! it leaves nothing half done and needs no second kind of result.

use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, Ordering};

static REQUESTED: AtomicBool = AtomicBool::new(false);

/// Payload of the panic that [`check`] raises.
#[derive(Clone, Copy, Debug)]
pub struct Interrupted;

/// Request that all running kernels stop.
pub fn request() {
    REQUESTED.store(true, Ordering::Relaxed);
}

/// Withdraw the request, so that kernels run again.
pub fn clear() {
    REQUESTED.store(false, Ordering::Relaxed);
}

/// Least number of items in one task of rayon, for `items` that each call [`check`]: each task unwinds on its own,
/// which takes a few microseconds.
pub fn min_task_len(items: usize) -> usize {
    const MOST_TASKS: usize = 256;
    items.div_ceil(MOST_TASKS).max(1)
}

/// Unwind with [`Interrupted`] if a caller has requested to stop.
#[inline]
pub fn check() {
    if REQUESTED.load(Ordering::Relaxed) {
        // Do not print the message of a panic: this is no error.
        resume_unwind(Box::new(Interrupted));
    }
}
