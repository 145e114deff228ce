//! What is known of a handle, in a byte.

/// What is known of a handle.
///
/// | flag | is set by | is cleared by |
/// |---|---|---|
/// | [`ALIVE`](Self::ALIVE) | insertion | removal |
/// | [`UNBOUNDED`](Self::UNBOUNDED) | insertion without a box | the object that gets the handle next |
/// | [`PENDING`](Self::PENDING) | every change, coming and going included | the next update |
/// | [`MOVED`](Self::MOVED) | an update that finds [`PENDING`](Self::PENDING) | the first that does not |
/// | [`REFILTERED`](Self::REFILTERED) | a change of the filter, of an object with a box | the next update |
///
/// Whatever is pending is in a list of pending changes, and what has moved in one of current ones,
/// or among the few unbounded objects: so no update looks at anything else.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Flags(u8);

impl Flags {
    /// There is an object with the handle.
    pub(super) const ALIVE: Self = Self(1);
    /// It has no end, and so no box.
    pub(super) const UNBOUNDED: Self = Self(2);
    /// Something changed since the last update.
    pub(super) const PENDING: Self = Self(4);
    /// Something changed between the last two updates: what the current pairs are about.
    pub(super) const MOVED: Self = Self(8);
    /// The filter changed since the last update.
    pub(super) const REFILTERED: Self = Self(16);

    /// These flags and others.
    #[inline]
    pub(super) const fn with(self, others: Self) -> Self {
        Self(self.0 | others.0)
    }

    /// Those of these flags that are among others.
    #[inline]
    pub(super) const fn among(self, others: Self) -> Self {
        Self(self.0 & others.0)
    }

    /// Returns `true` if a flag is set.
    #[inline]
    pub(super) const fn has(self, flag: Self) -> bool {
        self.0 & flag.0 != 0
    }

    /// Returns `true` if there is an object, and it has a box.
    #[inline]
    pub(super) const fn has_box(self) -> bool {
        self.0 & (Self::ALIVE.0 | Self::UNBOUNDED.0) == Self::ALIVE.0
    }

    /// Returns `true` if there is an object, and it has moved.
    #[inline]
    pub(super) const fn is_moved(self) -> bool {
        self.0 & (Self::ALIVE.0 | Self::MOVED.0) == Self::ALIVE.0 | Self::MOVED.0
    }

    /// Returns `true` if there is an object, and it has not moved.
    #[inline]
    pub(super) const fn is_resting(self) -> bool {
        self.0 & (Self::ALIVE.0 | Self::MOVED.0) == Self::ALIVE.0
    }

    #[inline]
    pub(super) const fn set(&mut self, flag: Self) {
        self.0 |= flag.0;
    }

    /// Clears a flag, unless it is to be kept. Without a branch.
    #[inline]
    pub(super) const fn clear_unless(&mut self, kept: bool, flag: Self) {
        self.0 &= if kept { !0 } else { !flag.0 };
    }
}
