//! What the index may have missed.

use bevy::{
    ecs::{archetype::Archetype, component::ComponentId},
    prelude::*,
};

use super::CollisionIndex;

/// What the index has to know to be right, though it may miss things: hooks may run while it is out
/// of the world.
#[derive(Resource, Debug, Default)]
pub(crate) struct Upkeep {
    /// The index that all entries are about.
    index: u64,
    /// Has something come to pass that it does not know of?
    missed: bool,
    /// The components that disable an entity, each with its observers.
    disabling: Vec<ComponentId>,
}

impl Upkeep {
    /// Takes note that something came to pass which the index does not know of.
    pub(crate) const fn miss(&mut self) {
        self.missed = true;
    }

    /// Did this index miss anything, or is it another than the last one?
    pub(crate) const fn is_due(&self, index: &CollisionIndex) -> bool {
        self.missed || self.index != index.number
    }

    /// Takes note that this index knows of everything.
    pub(crate) const fn done(&mut self, index: &CollisionIndex) {
        (self.index, self.missed) = (index.number, false);
    }

    /// Does one of the components that disable entities belong to this archetype?
    pub(crate) fn disables(&self, archetype: &Archetype) -> bool {
        self.disabling.iter().any(|id| archetype.contains(*id))
    }

    /// Is this component, which disables entities, observed?
    pub(crate) fn watches(&self, id: ComponentId) -> bool {
        self.disabling.contains(&id)
    }

    /// Takes note of a component that disables entities, and is observed from now on. What it
    /// disables already, was missed.
    pub(crate) fn watch(&mut self, id: ComponentId) {
        self.disabling.push(id);
        self.miss();
    }
}

/// Hooks note what they miss though nothing maintains the index.
pub(crate) fn register(app: &mut App) {
    app.init_resource::<Upkeep>();
}
