//! A cache of one value, shared by all maps with the same pixels.

use std::sync::{Arc, Mutex};

/// The last value that was computed, with its key.
///
/// The cache is skipped while another thread holds its lock: a forked process would wait for that thread forever.
pub struct Cache<K, V>(Mutex<Option<(K, Arc<V>)>>);

impl<K: Clone + PartialEq, V> Cache<K, V> {
    /// An empty cache.
    pub const fn new() -> Self {
        Self(Mutex::new(None))
    }

    /// The cached value if it belongs to `key`, else a new one.
    pub fn get(&self, key: &K, make: impl FnOnce() -> V) -> Arc<V> {
        if let Ok(last) = self.0.try_lock()
            && let Some((cached_key, value)) = &*last
            && cached_key == key
        {
            return value.clone();
        }
        let value = Arc::new(make());
        if let Ok(mut last) = self.0.try_lock() {
            *last = Some((key.clone(), value.clone()));
        }
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_computed_once_for_each_change_of_key() {
        let cache = Cache::new();
        let mut computed = Vec::new();
        for key in [1, 1, 2, 2, 1] {
            let value = cache.get(&key, || {
                computed.push(key);
                10 * key
            });
            assert_eq!(*value, 10 * key);
        }
        assert_eq!(computed, [1, 2, 1]);
    }

    /// Checks the state of a process that was forked while another thread held the lock.
    #[test]
    fn the_cache_does_not_wait_for_a_lock() {
        let cache = Cache::new();
        let lock = cache.0.lock();
        assert_eq!(*cache.get(&1, || 2), 2);
        drop(lock);
        assert_eq!(*cache.get(&1, || 3), 3);
        assert_eq!(*cache.get(&1, || 4), 3);
    }
}
