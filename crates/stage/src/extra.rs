//! What later work adds to a frame.

use std::any::Any;
use std::fmt;
use std::sync::Arc;

/// A value of a type that the stages do not know, such as what a flight shows of a revolution. A frame has room for one.
#[derive(Clone, Default)]
pub struct Extra(Option<Arc<dyn Any + Send + Sync>>);

impl Extra {
    /// Puts `value` in place of what is there.
    pub fn set(&mut self, value: impl Any + Send + Sync) {
        self.0 = Some(Arc::new(value));
    }

    /// The value, if it is a `T`.
    pub fn get<T: Any>(&self) -> Option<&T> {
        self.0.as_ref()?.downcast_ref()
    }

    /// Removes the value.
    pub fn clear(&mut self) {
        self.0 = None;
    }
}

impl fmt::Debug for Extra {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.is_some() { "Extra(..)" } else { "Extra" })
    }
}
