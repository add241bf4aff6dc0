//! The threads of the kernels.
//!
//! They are not those of rayon itself: a process that was forked after their first use, as by
//! `multiprocessing` on Linux or a loader of training data, has none of the threads of its parent, and
//! would wait for them for ever. Here it makes its own.

use std::sync::OnceLock;

use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// Run `work` without the GIL, with all threads of this process.
pub fn in_pool<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> T {
    static FIRST: OnceLock<Box<Pool>> = OnceLock::new();
    py.detach(|| of_process(std::process::id(), &FIRST).install(work))
}

/// The threads of a process, and those of a process that was forked from it.
struct Pool {
    process: u32,
    threads: ThreadPool,
    next: OnceLock<Box<Pool>>,
}

fn of_process(process: u32, place: &'static OnceLock<Box<Pool>>) -> &'static ThreadPool {
    let pool = place.get_or_init(|| {
        let threads = ThreadPoolBuilder::new().build().expect("the system starts threads");
        Box::new(Pool { process, threads, next: OnceLock::new() })
    });
    if pool.process == process { &pool.threads } else { of_process(process, &pool.next) }
}
