//! The threads of the kernels, and what they do when all goes wrong.
//!
//! They are not those of rayon itself: a process that was forked after their first use, as by
//! `multiprocessing` on Linux or a loader of training data, has none of the threads of its parent, and
//! would wait for them for ever. Here it makes its own. Where the system gives none, the caller's thread does
//! all work.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::OnceLock;

use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use super::error::EnvLightsError;
use crate::error::Result;

/// Run `work` without the GIL, with all threads of this process.
pub fn in_pool<T: Send>(py: Python<'_>, work: impl FnOnce() -> Result<T> + Send) -> PyResult<T> {
    static FIRST: OnceLock<Box<Pool>> = OnceLock::new();
    detached(py, || match of_process(std::process::id(), &FIRST) {
        Some(threads) => threads.install(work),
        None => in_this_thread(work),
    })
}

/// Run `work` without the GIL, in this thread. A panic is a mistake in the kernels, and is told as such.
pub fn detached<T: Send>(py: Python<'_>, work: impl FnOnce() -> Result<T> + Send) -> PyResult<T> {
    // What a panic leaves half done is not looked at again: kernels own all that they change.
    let done = py.detach(|| catch_unwind(AssertUnwindSafe(work)));
    done.map_err(|panic| EnvLightsError::new_err(told(panic.as_ref())))?.map_err(PyErr::from)
}

/// The message of a panic, and whose mistake it is.
fn told(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no reason");
    format!("a mistake in envlights, not in its input; please report it with what was given: {text}")
}

/// Run `work` with rayon's functions confined to this thread.
fn in_this_thread<T>(work: impl FnOnce() -> T) -> T {
    // From now on this thread is the only one of a pool, which must live as long; a second one is refused.
    if let Ok(pool) = ThreadPoolBuilder::new().num_threads(1).use_current_thread().build() {
        std::mem::forget(pool);
    }
    work()
}

/// The threads of a process, and those of a process that was forked from it.
struct Pool {
    process: u32,
    threads: ThreadPool,
    next: OnceLock<Box<Pool>>,
}

/// None where the system starts no threads.
fn of_process(process: u32, place: &'static OnceLock<Box<Pool>>) -> Option<&'static ThreadPool> {
    if place.get().is_none() {
        let threads = ThreadPoolBuilder::new().build().ok()?;
        // Another thread may have been faster; then its pool serves both.
        let _ = place.set(Box::new(Pool { process, threads, next: OnceLock::new() }));
    }
    let pool = place.get()?;
    if pool.process == process { Some(&pool.threads) } else { of_process(process, &pool.next) }
}
