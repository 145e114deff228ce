//! Which mesh becomes what.

use std::{any::type_name, cell::OnceCell, fmt, sync::Arc};

use bevy::{
    ecs::{reflect::ReflectComponent, world::EntityRef},
    prelude::*,
    reflect::ReflectRef,
};

use super::form::MeshForm;
use crate::ancestors;

/// What becomes of a mesh under an entity with [`ShapesFromMeshes`](super::ShapesFromMeshes): its
/// form, if it is to have a shape at all, and what else is inserted.
///
/// A [`MeshForm`] is one, and so is an `Option` of it.
///
/// ```
/// use bevy_octree::prelude::*;
///
/// let trigger = MeshRule::new(MeshForm::Cuboid).with((Sensor, CollisionEventsEnabled));
/// # let _ = trigger;
/// ```
#[derive(Clone, Debug, Default)]
pub struct MeshRule {
    pub(super) form: Option<MeshForm>,
    pub(super) extras: Vec<Extra>,
}

impl MeshRule {
    /// The rule for meshes that nothing is to collide with.
    pub const NONE: Self = Self {
        form: None,
        extras: Vec::new(),
    };

    /// Makes the rule that meshes have shapes of this form.
    #[must_use]
    pub const fn new(form: MeshForm) -> Self {
        Self {
            form: Some(form),
            extras: Vec::new(),
        }
    }

    /// Adds what is inserted along with the shape: collision layers, markers, whatever a game has.
    ///
    /// It is inserted before the shape comes, over what a mesh has of its kind, and is taken away
    /// again where another rule comes to apply. A rule without a form inserts nothing.
    #[must_use]
    pub fn with(mut self, bundle: impl Bundle + Clone) -> Self {
        self.extras.push(Extra::new(bundle));
        self
    }
}

impl From<MeshForm> for MeshRule {
    fn from(form: MeshForm) -> Self {
        Self::new(form)
    }
}

impl From<Option<MeshForm>> for MeshRule {
    fn from(form: Option<MeshForm>) -> Self {
        let extras = Vec::new();
        Self { form, extras }
    }
}

type Act = dyn Fn(&mut EntityWorldMut) + Send + Sync;

/// A bundle of some type that can be inserted, and removed.
#[derive(Clone)]
pub(super) struct Extra {
    name: &'static str,
    pub(super) insert: Arc<Act>,
    pub(super) remove: fn(&mut EntityWorldMut),
}

impl Extra {
    pub(super) fn new<B: Bundle + Clone>(bundle: B) -> Self {
        Self {
            name: type_name::<B>(),
            insert: Arc::new(move |entity| {
                entity.insert(bundle.clone());
            }),
            remove: |entity| {
                entity.remove::<B>();
            },
        }
    }
}

impl fmt::Debug for Extra {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name)
    }
}

/// A mesh under an entity with [`ShapesFromMeshes`](super::ShapesFromMeshes), as a function that
/// decides about it sees it.
pub struct FoundMesh<'w> {
    world: &'w World,
    mesh: EntityRef<'w>,
    root: Entity,
    material: OnceCell<Option<String>>,
}

impl<'w> FoundMesh<'w> {
    pub(super) fn new(world: &'w World, mesh: EntityRef<'w>, root: Entity) -> Self {
        Self {
            world,
            mesh,
            root,
            material: OnceCell::new(),
        }
    }

    /// Returns the entity that has the `Mesh3d`.
    #[must_use]
    pub const fn entity(&self) -> EntityRef<'w> {
        self.mesh
    }

    /// Returns the entity that has the `Mesh3d`, then its parent, and so on, up to the one with the
    /// rules, which is left out unless it is itself the mesh.
    pub fn path(&self) -> impl Iterator<Item = EntityRef<'w>> {
        let (world, mesh, root) = (self.world, self.mesh.id(), self.root);
        ancestors::up(mesh, move |entity| {
            let found = world.get_entity(entity).ok()?;
            let parent = found.get::<ChildOf>().map(ChildOf::parent);
            Some((found, parent.filter(|_| entity != root)))
        })
        .map_while(Result::ok)
        .filter(move |found| found.id() != root || mesh == root)
    }

    /// Returns the names along the [`path`](Self::path), the mesh's own first.
    pub fn names(&self) -> impl Iterator<Item = &'w str> {
        (self.path()).filter_map(|found| found.get::<Name>().map(Name::as_str))
    }

    /// Returns the name of the glTF material: what a component of the short type path
    /// `GltfMaterialName` says, if the app's type registry knows one.
    #[must_use]
    pub fn material(&self) -> Option<&str> {
        let material = self.material.get_or_init(|| self.find_material());
        material.as_deref()
    }

    fn find_material(&self) -> Option<String> {
        let registry = self.world.get_resource::<AppTypeRegistry>()?.read();
        let component = registry
            .get_with_short_type_path("GltfMaterialName")?
            .data::<ReflectComponent>()?;
        let ReflectRef::TupleStruct(name) = component.reflect(self.mesh)?.reflect_ref() else {
            return None;
        };
        name.field(0)?.try_downcast_ref::<String>().cloned()
    }
}

impl fmt::Debug for FoundMesh<'_> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_struct("FoundMesh")
            .field("entity", &self.mesh.id())
            .field("names", &self.names().collect::<Vec<_>>())
            .field("material", &self.material())
            .finish()
    }
}

/// A name, all that begin or end with something, or all that contain it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Pattern {
    text: String,
    starts_open: bool,
    ends_open: bool,
}

impl Pattern {
    pub(super) fn new(pattern: &str) -> Self {
        let (starts_open, rest) =
            (pattern.strip_prefix('*')).map_or((false, pattern), |rest| (true, rest));
        let (ends_open, text) = rest
            .strip_suffix('*')
            .map_or((false, rest), |text| (true, text));
        Self {
            text: text.into(),
            starts_open,
            ends_open,
        }
    }

    pub(super) fn fits(&self, name: &str) -> bool {
        match (self.starts_open, self.ends_open) {
            (false, false) => name == self.text,
            (false, true) => name.starts_with(&self.text),
            (true, false) => name.ends_with(&self.text),
            (true, true) => name.contains(&self.text),
        }
    }
}

type Decide = dyn Fn(&FoundMesh) -> Option<MeshRule> + Send + Sync;

/// Rules, of which the first that applies decides.
#[derive(Clone, Default)]
pub(super) struct Rules(pub(super) Vec<Selected>);

#[derive(Clone)]
pub(super) enum Selected {
    Name(Pattern, MeshRule),
    Material(Pattern, MeshRule),
    By(Arc<Decide>),
}

impl Rules {
    /// The rule that applies; `None` if none does.
    pub(super) fn decide(&self, mesh: &FoundMesh) -> Option<MeshRule> {
        self.0.iter().find_map(|selected| match selected {
            Selected::Name(pattern, rule) => (mesh.names())
                .any(|name| pattern.fits(name))
                .then(|| rule.clone()),
            Selected::Material(pattern, rule) => (mesh.material())
                .is_some_and(|name| pattern.fits(name))
                .then(|| rule.clone()),
            Selected::By(decide) => decide(mesh),
        })
    }
}

impl fmt::Debug for Selected {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Name(pattern, rule) => f.debug_tuple("Name").field(pattern).field(rule).finish(),
            Self::Material(pattern, rule) => f
                .debug_tuple("Material")
                .field(pattern)
                .field(rule)
                .finish(),
            Self::By(_) => f.write_str("By(..)"),
        }
    }
}

impl fmt::Debug for Rules {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_list().entries(&self.0).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stars_stand_at_the_ends_of_a_name() {
        let fits = |pattern: &str| {
            ["tree", "tree.001", "big_tree", "big_tree.001", "", "*"]
                .map(|name| Pattern::new(pattern).fits(name))
        };
        assert_eq!(fits("tree"), [true, false, false, false, false, false]);
        assert_eq!(fits("tree*"), [true, true, false, false, false, false]);
        assert_eq!(fits("*tree"), [true, false, true, false, false, false]);
        assert_eq!(fits("*tree*"), [true, true, true, true, false, false]);
        assert_eq!(fits("*"), [true; 6]);
        assert_eq!(fits("**"), [true; 6]);
        assert_eq!(fits(""), [false, false, false, false, true, false]);
    }
}
