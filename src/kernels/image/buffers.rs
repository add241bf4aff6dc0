//! Buffers of decoded rows, which are used again: their pages are mapped only once.

use std::sync::{Mutex, PoisonError};

/// Buffers that no thread uses at the moment.
#[derive(Default)]
pub(super) struct Buffers {
    free: Mutex<Vec<Vec<f32>>>,
}

impl Buffers {
    /// Result of `work` with a buffer, whose content is undefined.
    pub fn lend<T>(&self, work: impl FnOnce(&mut Vec<f32>) -> T) -> T {
        let mut buffer = self.free.lock().unwrap_or_else(PoisonError::into_inner).pop().unwrap_or_default();
        let result = work(&mut buffer);
        self.free.lock().unwrap_or_else(PoisonError::into_inner).push(buffer);
        result
    }
}
