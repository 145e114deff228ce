//! What a callback of a query returns.

use std::ops::ControlFlow;

/// What the callback of a query returns: nothing, to go on to the end, or a [`ControlFlow`], to
/// stop when it likes.
///
/// These two, and no others: the trait is sealed.
pub trait Flow: Answer {}

impl Flow for () {}
impl Flow for ControlFlow<()> {}

/// What a query reads from a [`Flow`].
pub trait Answer {
    /// Returns `true` if the query is to go on.
    fn goes_on(self) -> bool;
}

impl Answer for () {
    fn goes_on(self) -> bool {
        true
    }
}

impl Answer for ControlFlow<()> {
    fn goes_on(self) -> bool {
        self.is_continue()
    }
}
