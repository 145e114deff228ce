//! What a callback of a query returns.

use std::ops::ControlFlow;

/// What a callback returns: nothing, to go on to the end, or a [`ControlFlow`], to stop when it likes.
pub trait Flow {
    /// Shall the query go on?
    fn goes_on(self) -> bool;
}

impl Flow for () {
    fn goes_on(self) -> bool {
        true
    }
}

impl Flow for ControlFlow<()> {
    fn goes_on(self) -> bool {
        self.is_continue()
    }
}
