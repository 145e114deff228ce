//! Memory of those who ask more about a pair than its frame knows of.

use std::{any::Any, fmt};

/// Memory of one type or another, made when it is first asked for. What is in it is known to those
/// alone who ask for it; a clone is empty.
#[derive(Default)]
pub struct Memory(Option<Box<dyn Any + Send + Sync>>);

impl Memory {
    /// The memory of a type: a new one, if that of another type was asked for last.
    #[inline]
    pub fn of<T: Any + Default + Send + Sync>(&mut self) -> &mut T {
        let memory = self.0.get_or_insert_with(|| Box::new(T::default()));
        if !memory.is::<T>() {
            *memory = Box::new(T::default());
        }
        memory.downcast_mut().expect("it is of this type now")
    }
}

impl Clone for Memory {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl fmt::Debug for Memory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Memory").finish_non_exhaustive()
    }
}
