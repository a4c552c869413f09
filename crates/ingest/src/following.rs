//! Waiting for more of a recording that is still being written.

use std::fmt;
use std::sync::Arc;
use std::thread::sleep;
use std::time::Duration;

/// Between two looks at a file that did not grow.
const INTERVAL: Duration = Duration::from_millis(50);

/// Waits for more of a recording until there is some, or until whoever made this wants no more.
#[derive(Clone)]
pub struct Following(Arc<dyn Fn() -> bool + Send + Sync>);

impl Following {
    /// Waiting ends for good as soon as `is_over` is true.
    pub fn until(is_over: impl Fn() -> bool + Send + Sync + 'static) -> Self {
        Self(Arc::new(is_over))
    }

    /// Whether waiting is over.
    pub(crate) fn is_over(&self) -> bool {
        (self.0)()
    }

    /// Waits a moment; `false` if waiting is over.
    pub(crate) fn wait(&self) -> bool {
        if self.is_over() {
            return false;
        }
        sleep(INTERVAL);
        true
    }
}

impl fmt::Debug for Following {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Following")
    }
}
