//! Shapes for all meshes under an entity.

use std::{
    collections::{HashMap, HashSet},
    sync::Arc,
};

use bevy::{
    ecs::{lifecycle::HookContext, query::QueryState, world::DeferredWorld},
    mesh::Mesh3d,
    prelude::*,
};

use super::{
    form::MeshForm,
    progress::{
        MeshShapeCounts, Progress, Ruled, Settled, ShapesProgress, ShapesReady, tell_ready,
    },
    rules::{Extra, FoundMesh, MeshRule, Pattern, Rules, Selected},
    shape_from_mesh::{MeshShapeSystems, ShapeFromMesh, ShapeFromMeshError},
};
use crate::{
    ancestors,
    components::CollisionShape,
    schedule::{CollisionSystems, add_to_tick},
};

/// Has shapes built of all meshes under an entity, its own among them, by rules (feature `mesh`):
/// for scenes from glTF files, and whatever else is spawned below.
///
/// Each entity with a `Mesh3d` gets a [`ShapeFromMesh`] for it, and what the rule adds; so what is
/// said [there](ShapeFromMesh) of loading, sharing and changes is true of each. Meshes that come
/// later are found when they come: whenever a `Mesh3d` is inserted under the entity, or what has
/// some becomes a child there. When all are done, a [`ShapesReady`] tells; until then,
/// [`ShapesProgress`] has the numbers.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_octree::prelude::*;
///
/// collision_layers! {
///     enum Layer { Ground, Player }
/// }
///
/// # fn spawn(mut commands: Commands) {
/// commands.spawn((
///     // WorldAssetRoot(assets.load(GltfAssetLabel::Scene(0).from_asset("level.glb"))),
///     ShapesFromMeshes::new(MeshForm::AsItIs)
///         .with((StaticShape, CollisionLayers::new(Layer::Ground, LayerMask::ALL)))
///         .name("Grass*", None)
///         .name("*_box", MeshForm::Cuboid)
///         .name("Trigger*", MeshRule::new(MeshForm::Cuboid).with(Sensor))
///         .material("Water", None),
/// ));
/// # }
/// ```
///
/// # Rules
///
/// Rules are asked in the order in which they were added, and the first that applies to a mesh
/// decides; if none does, the rule for all others, which is that of [`new`](Self::new). Of several
/// `ShapesFromMeshes` above a mesh, the nearest counts alone.
///
/// An entity with a `ShapeFromMesh` or a [`CollisionShape`] of its own is left as it is.
///
/// # What changes
///
/// * A mesh that is moved elsewhere under the entity, or gets another `Mesh3d`, is decided about
///   anew. A new name, or a new material, is not looked at.
/// * So are all meshes, when the component is changed, or replaced by another: what rules gave is
///   taken away where they no longer do, and shapes stay where the form is the same.
/// * Removing the component leaves all as it is; what comes after that, gets nothing. Inserted
///   again, it decides anew.
/// * A scene that is spawned again is new meshes. Those of the old one go with their entities.
/// * What is taken from under the entity keeps its shape.
/// * A clone of the entity with all below has shapes of its own.
#[doc(alias(
    "AsyncSceneCollider",
    "ColliderConstructorHierarchy",
    "scene collider",
    "level",
    "glTF"
))]
#[derive(Component, Clone, Debug)]
#[require(ShapesProgress)]
#[component(on_remove = forget_progress)]
pub struct ShapesFromMeshes {
    /// For those that none of the others applies to.
    others: MeshRule,
    rules: Rules,
    /// What all get that get a shape.
    extras: Vec<Extra>,
}

impl ShapesFromMeshes {
    /// Makes the component by the rule for all meshes that no other rule applies to: a [`MeshForm`],
    /// `None`, or a [`MeshRule`].
    #[must_use]
    pub fn new(rule: impl Into<MeshRule>) -> Self {
        Self {
            others: rule.into(),
            rules: Rules::default(),
            extras: Vec::new(),
        }
    }

    /// Adds what is inserted with every shape: collision layers, markers, whatever a game has. What
    /// the rule of a mesh adds is inserted over it.
    ///
    /// See [`MeshRule::with`].
    #[must_use]
    pub fn with(mut self, bundle: impl Bundle + Clone) -> Self {
        self.extras.push(Extra::new(bundle));
        self
    }

    /// Adds a rule for meshes by name: if the mesh, or anything between it and this entity, has it.
    ///
    /// Names are compared letter by letter. A star at the end of `pattern` stands for whatever
    /// follows, as in `Tree*`, and one at the start for whatever is before, as in `*_col`.
    #[must_use]
    pub fn name(self, pattern: &str, rule: impl Into<MeshRule>) -> Self {
        self.rule(Selected::Name(Pattern::new(pattern), rule.into()))
    }

    /// Adds a rule for meshes by the name of their glTF material, with stars as those of
    /// [`name`](Self::name).
    ///
    /// It is that of the component `GltfMaterialName`, which Bevy's loader inserts. Where that is
    /// not a registered type, the rule applies to nothing.
    #[must_use]
    pub fn material(self, pattern: &str, rule: impl Into<MeshRule>) -> Self {
        self.rule(Selected::Material(Pattern::new(pattern), rule.into()))
    }

    /// Adds a function that decides: by other components, as `GltfExtras`, or by a table of the
    /// game's. Where it returns `None`, the next rule is asked.
    ///
    /// ```
    /// use bevy::prelude::*;
    /// use bevy_octree::prelude::*;
    ///
    /// #[derive(Component)]
    /// struct Decoration;
    ///
    /// let rules = ShapesFromMeshes::default().decide(|mesh| {
    ///     let is_decoration = mesh.path().any(|entity| entity.contains::<Decoration>());
    ///     is_decoration.then_some(MeshRule::NONE)
    /// });
    /// # let _ = rules;
    /// ```
    #[must_use]
    pub fn decide(
        self,
        decide: impl Fn(&FoundMesh) -> Option<MeshRule> + Send + Sync + 'static,
    ) -> Self {
        self.rule(Selected::By(Arc::new(decide)))
    }

    fn rule(mut self, selected: Selected) -> Self {
        self.rules.0.push(selected);
        self
    }

    /// The form of a mesh, and what comes with it.
    fn decision(&self, mesh: &FoundMesh) -> Option<(MeshForm, Vec<Extra>)> {
        let rule = (self.rules.decide(mesh)).unwrap_or_else(|| self.others.clone());
        let extras = self.extras.iter().cloned().chain(rule.extras).collect();
        Some((rule.form?, extras))
    }
}

/// All meshes, as they are.
impl Default for ShapesFromMeshes {
    fn default() -> Self {
        Self::new(MeshForm::default())
    }
}

/// Without rules there is no progress.
fn forget_progress(mut world: DeferredWorld, context: HookContext) {
    let mut commands = world.commands();
    commands
        .entity(context.entity)
        .try_remove::<ShapesProgress>();
}

/// What came since that was last looked at. Until there are rules, nobody listens.
#[derive(Resource, Debug, Default)]
struct Arrivals {
    is_listening: bool,
    list: Vec<Arrival>,
}

#[derive(Clone, Copy, Debug)]
enum Arrival {
    /// An entity got a mesh, or another one.
    Mesh(Entity),
    /// An entity got a parent, or another one.
    Child(Entity),
}

pub(super) fn register(app: &mut App) {
    app.register_type::<MeshShapeCounts>()
        .register_type::<ShapesReady>()
        .init_resource::<Arrivals>()
        .init_resource::<Settled>();
    add_to_tick(app, |app, schedule| {
        app.add_systems(
            schedule,
            (
                // What else is in the set measures, or has nothing to do with meshes.
                follow_rules
                    .run_if(has_news)
                    .before(MeshShapeSystems)
                    .ambiguous_with_all(),
                tell_ready
                    .run_if(any_with_component::<ShapesProgress>)
                    .after(MeshShapeSystems),
            )
                .in_set(CollisionSystems::First),
        );
    });
}

fn has_news(arrivals: Res<Arrivals>, changed: Query<(), Changed<ShapesFromMeshes>>) -> bool {
    !arrivals.list.is_empty() || !changed.is_empty()
}

/// Gives meshes that are new, or whose rules are, what these say.
fn follow_rules(world: &mut World, changed: &mut QueryState<Entity, Changed<ShapesFromMeshes>>) {
    let roots: Vec<Entity> = changed.iter(world).collect();
    let mut arrivals = world.resource_mut::<Arrivals>();
    let list = std::mem::take(&mut arrivals.list);
    if !std::mem::replace(&mut arrivals.is_listening, true) {
        listen(world);
    }
    let mut found = Found::default();
    for root in roots {
        found.below(world, root, root);
    }
    for arrival in list {
        let (Arrival::Mesh(entity) | Arrival::Child(entity)) = arrival;
        if let Some(root) = root_of(world, entity) {
            match arrival {
                Arrival::Mesh(mesh) => found.mesh(world, mesh, root, true),
                Arrival::Child(child) => found.below(world, child, root),
            }
        }
    }
    // All is decided by what is there before anything is done.
    let decisions: Vec<Decision> = (found.list.iter())
        .filter_map(|mesh| Decision::about(world, mesh))
        .collect();
    for decision in decisions {
        decision.carry_out(world);
    }
}

fn listen(world: &mut World) {
    world.add_observer(
        |on: On<Insert, Mesh3d>, arrivals: Option<ResMut<Arrivals>>| {
            if let Some(mut arrivals) = arrivals {
                arrivals.list.push(Arrival::Mesh(on.entity));
            }
        },
    );
    world.add_observer(
        |on: On<Insert, ChildOf>, arrivals: Option<ResMut<Arrivals>>| {
            if let Some(mut arrivals) = arrivals {
                arrivals.list.push(Arrival::Child(on.entity));
            }
        },
    );
}

/// The nearest that has rules, of an entity and all that it hangs on.
fn root_of(world: &World, entity: Entity) -> Option<Entity> {
    ancestors::up(entity, |entity| {
        let found = world.get_entity(entity).ok()?;
        let root = found.contains::<ShapesFromMeshes>().then_some(entity);
        Some((root, found.get::<ChildOf>().map(ChildOf::parent)))
    })
    .map_while(Result::ok)
    .flatten()
    .next()
}

/// Meshes that something is to be decided about, each once.
#[derive(Default)]
struct Found {
    list: Vec<ToDecide>,
    slots: HashMap<Entity, usize>,
}

struct ToDecide {
    mesh: Entity,
    root: Entity,
    /// Does it have another mesh than before?
    is_other: bool,
}

impl Found {
    /// Takes an entity, if it has a mesh.
    fn mesh(&mut self, world: &World, mesh: Entity, root: Entity, is_other: bool) {
        if world.get::<Mesh3d>(mesh).is_none() {
            return;
        }
        let slot = *self.slots.entry(mesh).or_insert_with(|| {
            self.list.push(ToDecide {
                mesh,
                root,
                is_other,
            });
            self.list.len() - 1
        });
        self.list[slot].is_other |= is_other;
    }

    /// Takes all at an entity and below, but for what is below others with rules.
    fn below(&mut self, world: &World, top: Entity, root: Entity) {
        let (mut next, mut seen) = (vec![top], HashSet::from([top]));
        while let Some(entity) = next.pop() {
            if entity != root && world.get::<ShapesFromMeshes>(entity).is_some() {
                continue;
            }
            self.mesh(world, entity, root, false);
            if let Some(children) = world.get::<Children>(entity) {
                // The first of them is the next.
                let new = children.iter().rev().filter(|child| seen.insert(*child));
                next.extend(new);
            }
        }
    }
}

/// What is to be done about a mesh.
struct Decision {
    mesh: Entity,
    root: Entity,
    /// `None`: it is to have no shape.
    given: Option<(MeshForm, Vec<Extra>)>,
    /// It is its own master.
    is_own: bool,
    is_other: bool,
}

impl Decision {
    fn about(world: &World, to_decide: &ToDecide) -> Option<Self> {
        let &ToDecide {
            mesh,
            root,
            is_other,
        } = to_decide;
        let (entity, rules) = (world.get_entity(mesh).ok()?, world.get(root)?);
        let rules: &ShapesFromMeshes = rules;
        let is_own = !entity.contains::<Ruled>()
            && (entity.contains::<ShapeFromMesh>() || entity.contains::<CollisionShape>());
        let given = if is_own {
            None
        } else {
            rules.decision(&FoundMesh::new(world, entity, root))
        };
        Some(Self {
            mesh,
            root,
            given,
            is_own,
            is_other,
        })
    }

    fn carry_out(self, world: &mut World) {
        let (mesh, root, is_other) = (self.mesh, self.root, self.is_other);
        let progress = if self.is_own {
            Some(Progress::LeftOut)
        } else {
            world.get_entity_mut(mesh).ok().and_then(|mut entity| {
                take_extras(&mut entity)?;
                match self.given {
                    Some((form, extras)) => give(entity, root, form, extras, is_other),
                    None => take_shape(entity),
                }
            })
        };
        if let Some(progress) = progress
            && let Some(mut known) = world.get_mut::<ShapesProgress>(root)
        {
            known.note(mesh, progress);
        }
    }
}

/// Takes away what rules inserted beside shapes. Observers may despawn the entity meanwhile: `None`.
fn take_extras(entity: &mut EntityWorldMut) -> Option<()> {
    if let Some(mut ruled) = entity.get_mut::<Ruled>() {
        for extra in std::mem::take(&mut ruled.extras) {
            (extra.remove)(entity);
            alive(entity)?;
        }
    }
    Some(())
}

fn give(
    mut entity: EntityWorldMut,
    root: Entity,
    form: MeshForm,
    extras: Vec<Extra>,
    is_other: bool,
) -> Option<Progress> {
    for extra in &extras {
        (extra.insert)(&mut entity);
        alive(&entity)?;
    }
    entity.insert(Ruled { root, extras });
    let asks = ShapeFromMesh::own(form);
    if entity.get() == Some(&asks) && !is_other {
        return Some(if entity.contains::<ShapeFromMeshError>() {
            Progress::Error
        } else if entity.contains::<CollisionShape>() {
            Progress::Shape
        } else {
            Progress::Waiting
        });
    }
    if entity.get() != Some(&asks) {
        entity.insert(asks);
        alive(&entity)?;
    }
    Some(Progress::Waiting)
}

/// Takes away the shape that rules gave.
fn take_shape(mut entity: EntityWorldMut) -> Option<Progress> {
    if entity.contains::<Ruled>() {
        entity.remove::<(Ruled, ShapeFromMesh, CollisionShape)>();
        alive(&entity)?;
    }
    Some(Progress::LeftOut)
}

fn alive(entity: &EntityWorldMut) -> Option<()> {
    (!entity.is_despawned()).then_some(())
}
