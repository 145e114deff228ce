//! Which entities may belong to another body than was known: noted by hooks, below all who ask.

use bevy::{ecs::world::DeferredWorld, prelude::*};

/// So many entities are noted one by one; beyond that, all there are have to be looked at.
const MOST_NOTED: usize = 1 << 16;

/// What is to be looked up anew: to which bodies entities belong, and which parts are swept. As long
/// as there are no bodies, nothing is noted.
#[derive(Resource, Debug, Default)]
pub(crate) struct Regroup {
    /// How many bodies there are.
    bodies: usize,
    /// Is it observed where entities hang?
    observes: bool,
    /// Is it the library that says what belongs to what? What others say is looked at.
    writes: bool,
    due: Due,
    /// Parts that came or went, and bodies that are swept anew, or no longer are.
    to_sweep: Due,
}

/// Entities that are to be looked at, some maybe several times.
#[derive(Debug, Default)]
pub(crate) struct Due {
    pub(crate) entities: Vec<Entity>,
    /// All there are, those listed or not?
    pub(crate) all: bool,
}

impl Due {
    fn note(&mut self, entity: Entity) {
        if self.entities.len() < MOST_NOTED {
            self.entities.push(entity);
        } else {
            self.all = true;
        }
    }

    const fn is_empty(&self) -> bool {
        self.entities.is_empty() && !self.all
    }
}

impl Regroup {
    pub(crate) const fn add_body(&mut self) {
        self.bodies += 1;
    }

    /// Returns `true` if nobody observes yet where entities hang: from now on, somebody does.
    pub(crate) const fn observe(&mut self) -> bool {
        !std::mem::replace(&mut self.observes, true)
    }

    pub(crate) const fn remove_body(&mut self) {
        self.bodies = self.bodies.saturating_sub(1);
    }

    /// There are so many bodies, of which nothing is known.
    pub(crate) const fn begin(&mut self, bodies: usize) {
        self.bodies = bodies;
        self.due.all = bodies > 0;
    }

    /// From now on, or until now, it is the library that says what belongs to what.
    pub(crate) const fn set_writes(&mut self, writes: bool) {
        self.writes = writes;
    }

    /// What hangs on this entity, itself included, may belong to another body.
    pub(crate) fn note(&mut self, entity: Entity) {
        self.due.note(entity);
    }

    pub(crate) fn note_to_sweep(&mut self, entity: Entity) {
        self.to_sweep.note(entity);
    }

    pub(crate) const fn is_due(&self) -> bool {
        !self.due.is_empty()
    }

    pub(crate) const fn is_sweep_due(&self) -> bool {
        !self.to_sweep.is_empty()
    }

    pub(crate) const fn take(&mut self) -> Due {
        std::mem::replace(&mut self.due, NOTHING)
    }

    pub(crate) const fn take_to_sweep(&mut self) -> Due {
        std::mem::replace(&mut self.to_sweep, NOTHING)
    }
}

const NOTHING: Due = Due {
    entities: Vec::new(),
    all: false,
};

/// Where there are bodies, what hangs on this entity, itself included, may belong to another one.
pub(crate) fn note(world: &mut DeferredWorld, entity: Entity) {
    if let Some(mut regroup) = world.get_resource_mut::<Regroup>()
        && regroup.bodies > 0
    {
        regroup.note(entity);
    }
}

/// Somebody said what an entity belongs to: unless that was the library, it is to be looked up, though
/// there be no bodies.
pub(crate) fn note_written(world: &mut DeferredWorld, entity: Entity) {
    if let Some(mut regroup) = world.get_resource_mut::<Regroup>()
        && !regroup.writes
    {
        regroup.note(entity);
    }
}

/// Where there are bodies, an entity is swept anew, or no longer is.
pub(crate) fn note_to_sweep(world: &mut DeferredWorld, entity: Entity) {
    if let Some(mut regroup) = world.get_resource_mut::<Regroup>()
        && regroup.bodies > 0
    {
        regroup.note_to_sweep(entity);
    }
}
