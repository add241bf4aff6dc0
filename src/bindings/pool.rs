//! The threads of the kernels, and what they do when all goes wrong.
//!
//! They are not those of rayon itself: a process that was forked after their first use, as by
//! `multiprocessing` on Linux or a loader of training data, has none of the threads of its parent, and
//! would wait for them for ever. Here it makes its own. Where the system gives none, the caller's thread does
//! all work.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{OnceLock, mpsc};
use std::time::Duration;

use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use super::error::EnvLightsError;
use crate::error::Result;
use crate::interrupt::{self, Interruption};

/// Run `work` without the GIL, with all threads of this process: for kernels that end within tenths of a second
/// whatever they are given.
pub fn in_pool<T: Send>(py: Python<'_>, work: impl Fn() -> Result<T> + Send + Sync) -> PyResult<T> {
    run(py, &work, |threads| (threads.install(|| catch(&work)), None))
}

/// Run `work` without the GIL, with all threads of this process; a signal such as that of Ctrl-C ends it.
///
/// Watching costs about 15 microseconds a call, as much as a small kernel takes.
pub fn interruptible<T: Send>(py: Python<'_>, work: impl Fn() -> Result<T> + Send + Sync) -> PyResult<T> {
    run(py, &work, |threads| watch_signals(threads, &work))
}

/// Run `work` by `start` in the pool, again where another thread of Python was interrupted, and all work with it.
fn run<T: Send>(
    py: Python<'_>,
    work: &(impl Fn() -> Result<T> + Sync),
    start: impl Fn(&ThreadPool) -> (Outcome<T>, Option<PyErr>) + Send + Sync,
) -> PyResult<T> {
    let Some(threads) = py.detach(current) else {
        return detached(py, || in_this_thread(work));
    };
    loop {
        let (done, signal) = py.detach(|| start(threads));
        if let Some(signal) = signal {
            return Err(signal);
        }
        match done {
            Err(payload) if payload.is::<Interruption>() => {}
            done => return answer(done),
        }
    }
}

/// Run `work` over that many `numbers`, for kernels that use one thread: as [`detached`] where they are few, else as
/// [`interruptible`].
///
/// To reach the pool takes some 50 microseconds, more than such a kernel does.
pub fn by_size<T: Send>(
    py: Python<'_>,
    numbers: usize,
    work: impl Fn() -> Result<T> + Send + Sync,
) -> PyResult<T> {
    /// Numbers that any such kernel reads or writes within some milliseconds.
    const FEW: usize = 1 << 16;
    if numbers <= FEW { detached(py, work) } else { interruptible(py, work) }
}

/// Run `work` without the GIL, in this thread: for kernels that take no time worth an interruption.
///
/// An interruption that was meant for the kernel of another thread of Python may end it too; it then runs again.
pub fn detached<T: Send>(py: Python<'_>, work: impl Fn() -> Result<T> + Send + Sync) -> PyResult<T> {
    loop {
        match py.detach(|| catch(&work)) {
            Err(payload) if payload.is::<Interruption>() => {}
            done => return answer(done),
        }
    }
}

/// Result of a kernel, or the payload of its panic.
type Outcome<T> = std::result::Result<Result<T>, Box<dyn Any + Send>>;

/// Run `work` and catch a panic. Kernels own all that they change, so nothing half done is visible afterwards.
fn catch<T>(work: impl FnOnce() -> Result<T>) -> Outcome<T> {
    catch_unwind(AssertUnwindSafe(work))
}

/// Run `work` in the pool while this thread checks for signals; the second result is a signal that ended it.
fn watch_signals<T: Send>(
    threads: &ThreadPool,
    work: &(impl Fn() -> Result<T> + Sync),
) -> (Outcome<T>, Option<PyErr>) {
    /// Time between two checks; a user does not notice it, and it costs nothing.
    const BETWEEN: Duration = Duration::from_millis(50);
    threads.in_place_scope(|scope| {
        let (sender, receiver) = mpsc::channel();
        scope.spawn(move |_| sender.send(catch(work)).expect("the receiver waits"));
        let mut signal = None;
        let done = loop {
            if let Ok(done) = receiver.recv_timeout(BETWEEN) {
                break done;
            }
            if signal.is_none() {
                #[expect(clippy::redundant_closure_for_method_calls, reason = "the method has one lifetime")]
                let caught = Python::attach(|py| py.check_signals());
                signal = caught.err();
                if signal.is_some() {
                    interrupt::request();
                }
            }
        };
        if signal.is_some() {
            interrupt::clear();
        }
        (done, signal)
    })
}

/// Result for Python; a panic becomes an internal error.
fn answer<T>(done: Outcome<T>) -> PyResult<T> {
    done.map_err(|panic| EnvLightsError::new_err(panic_message(panic.as_ref())))?.map_err(PyErr::from)
}

/// Message of a panic.
fn panic_message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no reason");
    format!("internal error in envlights; please report it with the arguments of the call: {text}")
}

/// Run `work` with rayon's functions confined to this thread.
fn in_this_thread<T>(work: impl FnOnce() -> T) -> T {
    // From now on this thread is the only one of a pool, which must live as long; a second one is refused.
    if let Ok(pool) = ThreadPoolBuilder::new().num_threads(1).use_current_thread().build() {
        std::mem::forget(pool);
    }
    work()
}

/// Requested number of threads; 0 means `RAYON_NUM_THREADS`, or else the number of cores.
static WANTED: AtomicUsize = AtomicUsize::new(0);

/// Set the number of threads from the next call on, if `wanted` is known, and return the number in use.
#[pyfunction]
pub fn threads(py: Python<'_>, wanted: Option<usize>) -> usize {
    if let Some(wanted) = wanted {
        WANTED.store(wanted, Ordering::Relaxed);
    }
    py.detach(|| current().map_or(1, ThreadPool::current_num_threads))
}

/// The threads of a process, and those of a process that was forked from it, or of another number.
struct Pool {
    process: u32,
    wanted: usize,
    threads: ThreadPool,
    next: OnceLock<Box<Pool>>,
}

/// The threads that are wanted in this process; none where the system starts no threads.
fn current() -> Option<&'static ThreadPool> {
    static FIRST: OnceLock<Box<Pool>> = OnceLock::new();
    of_process(std::process::id(), WANTED.load(Ordering::Relaxed), &FIRST)
}

/// The first pool from `place` on that is of this process and number; it is made where there is none.
fn of_process(
    process: u32,
    wanted: usize,
    place: &'static OnceLock<Box<Pool>>,
) -> Option<&'static ThreadPool> {
    if place.get().is_none() {
        let threads = ThreadPoolBuilder::new().num_threads(wanted).build().ok()?;
        // Another thread may have been faster; then its pool serves both.
        let _ = place.set(Box::new(Pool { process, wanted, threads, next: OnceLock::new() }));
    }
    let pool = place.get()?;
    let fits = pool.process == process && pool.wanted == wanted;
    if fits { Some(&pool.threads) } else { of_process(process, wanted, &pool.next) }
}
