//! Threads that run the kernels: signals, panics and forked processes.
//!
//! They are not rayon's global threads: a process that is forked after their first use (by `multiprocessing` on
//! Linux or by a data loader) does not inherit them and would wait for ever. Here each process starts its own. If
//! the system refuses to start threads, the calling thread does all the work.

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

/// Run `work` without the GIL on all threads of this process, for kernels that end within tenths of a second.
pub fn in_pool<T: Send>(py: Python<'_>, work: impl Fn() -> Result<T> + Send + Sync) -> PyResult<T> {
    run(py, &work, |threads| (threads.install(|| catch(&work)), None))
}

/// Run `work` without the GIL on all threads of this process, and stop it when a signal such as Ctrl-C arrives.
///
/// Watching for signals costs about 15 microseconds per call.
pub fn interruptible<T: Send>(py: Python<'_>, work: impl Fn() -> Result<T> + Send + Sync) -> PyResult<T> {
    run(py, &work, |threads| watch(threads, &work))
}

/// Call `start`, which runs `work` in the pool; repeat this if a signal to another Python thread interrupted it.
fn run<T: Send>(
    py: Python<'_>,
    work: &(impl Fn() -> Result<T> + Sync),
    start: impl Fn(&ThreadPool) -> (Outcome<T>, Option<PyErr>) + Send + Sync,
) -> PyResult<T> {
    let Some(threads) = py.detach(current) else {
        return without_gil(py, || in_this_thread(work));
    };
    loop {
        let (done, signal) = py.detach(|| start(threads));
        if let Some(signal) = signal {
            return Err(signal);
        }
        match done {
            Err(payload) if payload.is::<Interruption>() => {}
            done => return into_result(done),
        }
    }
}

/// Run single-threaded `work` over that many `numbers`: [`without_gil`] if they are few, else [`interruptible`].
///
/// Entry into the pool costs about 50 microseconds, more than such a kernel needs for few numbers.
pub fn by_size<T: Send>(
    py: Python<'_>,
    numbers: usize,
    work: impl Fn() -> Result<T> + Send + Sync,
) -> PyResult<T> {
    /// Numbers that any such kernel processes within a few milliseconds.
    const FEW: usize = 1 << 16;
    if numbers <= FEW { without_gil(py, work) } else { interruptible(py, work) }
}

/// Run `work` without the GIL in this thread, for kernels that are too short to be interrupted.
///
/// If the interruption of another Python thread stops it, it runs again.
pub fn without_gil<T: Send>(py: Python<'_>, work: impl Fn() -> Result<T> + Send + Sync) -> PyResult<T> {
    loop {
        match py.detach(|| catch(&work)) {
            Err(payload) if payload.is::<Interruption>() => {}
            done => return into_result(done),
        }
    }
}

/// Result of a kernel, or the payload of its panic.
type Outcome<T> = std::result::Result<Result<T>, Box<dyn Any + Send>>;

/// Run `work` and catch its panic. Kernels own everything that they change, so nothing half done is visible.
fn catch<T>(work: impl FnOnce() -> Result<T>) -> Outcome<T> {
    catch_unwind(AssertUnwindSafe(work))
}

/// Run `work` in the pool while this thread checks for signals; return the signal that stopped it, if any.
fn watch<T: Send>(
    threads: &ThreadPool,
    work: &(impl Fn() -> Result<T> + Sync),
) -> (Outcome<T>, Option<PyErr>) {
    /// Interval between two checks for signals: short enough that a person does not notice.
    const INTERVAL: Duration = Duration::from_millis(50);
    threads.in_place_scope(|scope| {
        let (sender, receiver) = mpsc::channel();
        scope.spawn(move |_| sender.send(catch(work)).expect("the receiver waits"));
        let mut signal = None;
        let done = loop {
            if let Ok(done) = receiver.recv_timeout(INTERVAL) {
                break done;
            }
            if signal.is_none() {
                #[expect(clippy::redundant_closure_for_method_calls, reason = "the method has one lifetime")]
                let checked = Python::attach(|py| py.check_signals());
                signal = checked.err();
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

/// Result for Python: a value, a refusal, or the report of a panic as an internal error.
fn into_result<T>(done: Outcome<T>) -> PyResult<T> {
    done.map_err(|panic| EnvLightsError::new_err(internal_error(panic.as_ref())))?.map_err(PyErr::from)
}

/// Sentence about a panic in a kernel.
fn internal_error(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no reason");
    format!("internal error in envlights; please report it with the arguments of the call: {text}")
}

/// Run `work` with rayon restricted to this thread.
fn in_this_thread<T>(work: impl FnOnce() -> T) -> T {
    // Keep the pool for the life of this thread; rayon refuses a second one.
    if let Ok(pool) = ThreadPoolBuilder::new().num_threads(1).use_current_thread().build() {
        std::mem::forget(pool);
    }
    work()
}

/// Requested number of threads; 0 means `RAYON_NUM_THREADS` or the number of cores.
static REQUESTED: AtomicUsize = AtomicUsize::new(0);

/// Set the number of threads from the next call on, unless `wanted` is `None`; return the number in use.
#[pyfunction]
pub fn threads(py: Python<'_>, wanted: Option<usize>) -> usize {
    if let Some(wanted) = wanted {
        REQUESTED.store(wanted, Ordering::Relaxed);
    }
    py.detach(|| current().map_or(1, ThreadPool::current_num_threads))
}

/// Thread pool of one process with one number of threads, and a link to the next such pool.
struct Pool {
    process: u32,
    wanted: usize,
    threads: ThreadPool,
    next: OnceLock<Box<Pool>>,
}

/// Threads of this process in the requested number; none if the system refuses to start threads.
fn current() -> Option<&'static ThreadPool> {
    static FIRST: OnceLock<Box<Pool>> = OnceLock::new();
    of_process(std::process::id(), REQUESTED.load(Ordering::Relaxed), &FIRST)
}

/// First pool from `link` on that belongs to this process and number of threads, created if there is none.
fn of_process(
    process: u32,
    wanted: usize,
    link: &'static OnceLock<Box<Pool>>,
) -> Option<&'static ThreadPool> {
    if link.get().is_none() {
        let threads = ThreadPoolBuilder::new().num_threads(wanted).build().ok()?;
        // If another thread was faster, use its pool.
        let _ = link.set(Box::new(Pool { process, wanted, threads, next: OnceLock::new() }));
    }
    let pool = link.get()?;
    let fits = pool.process == process && pool.wanted == wanted;
    if fits { Some(&pool.threads) } else { of_process(process, wanted, &pool.next) }
}
