//! How things look: a solid for each shape, in a colour that tells what happens to it.

use bevy::prelude::*;
use bevy_octree::{
    broad_phase::ObjectOctree,
    collision_index::CollisionIndex,
    components::BroadPhaseProxy,
    filters::{Detector, Sensor, StaticShape},
    prelude::*,
};

use crate::{
    play::Play,
    scene::Began,
    settings::{Leaves, Settings},
    solid::Solids,
};

/// How long a hit is seen, in ticks.
const GLOW: u64 = 10;

/// What is to be seen of an entity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum State {
    /// It moves, and touches nothing.
    #[default]
    Moving,
    /// It touched something, in this tick or just before.
    Hit,
    /// It is listed in more than one leaf of the octree.
    Straddling,
    /// It did not move in this tick.
    Resting,
    /// It never meets its kind.
    Static,
    /// Nothing bounces off it.
    Sensor,
    /// A sensor that has something in it.
    Triggered,
}

impl State {
    /// All of them, each with the word for it in the panel.
    pub const ALL: [(Self, &str); 7] = [
        (Self::Moving, "moving"),
        (Self::Hit, "hit"),
        (Self::Straddling, "in several leaves"),
        (Self::Resting, "at rest"),
        (Self::Static, "static"),
        (Self::Sensor, "sensor"),
        (Self::Triggered, "sensor, entered"),
    ];

    /// The colours of Okabe and Ito, which the colour-blind tell apart too; what stays is grey.
    pub const fn color(self) -> Color {
        match self {
            Self::Moving => Color::srgb(0.34, 0.71, 0.91),
            Self::Hit => Color::srgb(0.84, 0.27, 0.0),
            Self::Straddling => Color::srgb(0.90, 0.62, 0.0),
            Self::Resting => Color::srgb(0.58, 0.62, 0.68),
            Self::Static => Color::srgb(0.30, 0.33, 0.38),
            Self::Sensor => Color::srgba(0.0, 0.62, 0.45, 0.25),
            Self::Triggered => Color::srgba(0.80, 0.47, 0.65, 0.45),
        }
    }
}

/// The colour of the palette that stands for no state.
pub const YELLOW: Color = Color::srgb(0.94, 0.89, 0.26);

/// A material for each state.
#[derive(Resource)]
pub struct Palette([Handle<StandardMaterial>; State::ALL.len()]);

impl FromWorld for Palette {
    fn from_world(world: &mut World) -> Self {
        let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
        Self(State::ALL.map(|(state, _)| {
            let color = state.color();
            materials.add(StandardMaterial {
                base_color: color,
                perceptual_roughness: 0.55,
                metallic: 0.0,
                reflectance: 0.35,
                alpha_mode: if color.alpha() < 1.0 {
                    AlphaMode::Blend
                } else {
                    AlphaMode::Opaque
                },
                double_sided: true,
                cull_mode: None,
                ..default()
            })
        }))
    }
}

impl Palette {
    fn of(&self, state: State) -> &Handle<StandardMaterial> {
        let index = State::ALL.iter().position(|(other, _)| *other == state);
        &self.0[index.unwrap_or_default()]
    }
}

/// What an entity is painted as.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct Painted {
    /// The tick in which it last hit something, or was hit, and one more.
    hit: u64,
}

/// Keeps an entity in the look that its scene gave it.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct OwnLook;

type Undressed = (Changed<CollisionShape>, Without<OwnLook>);

/// What has a shape is drawn as that shape.
pub fn dress(
    shapes: Query<(Entity, &CollisionShape, Option<&Painted>), Undressed>,
    palette: Res<Palette>,
    mut solids: ResMut<Solids>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut commands: Commands,
) {
    for (entity, shape, painted) in &shapes {
        let Some(mesh) = solids.mesh_of(&shape.0, &mut meshes) else {
            warn_once!(
                "there is a shape that the gallery cannot draw: {:?}",
                shape.0
            );
            continue;
        };
        let mut entity = commands.entity(entity);
        entity.try_insert(Mesh3d(mesh));
        if painted.is_none() {
            let material = palette.of(State::default()).clone();
            entity.try_insert((MeshMaterial3d(material), Painted::default()));
        }
    }
}

/// A scene that begins has other shapes.
pub fn forget_solids(_: On<Began>, mut solids: ResMut<Solids>) {
    *solids = Solids::default();
}

type Entities<'w, 's> = Query<
    'w,
    's,
    (
        Entity,
        &'static BroadPhaseProxy,
        Ref<'static, GlobalTransform>,
        Has<StaticShape>,
        Has<Sensor>,
        Has<Detector>,
        &'static mut Painted,
        &'static mut MeshMaterial3d<StandardMaterial>,
    ),
>;

/// Paints each in the colour of its state, after the ticks of a frame.
pub fn paint(
    index: Res<CollisionIndex>,
    contacts: Res<Contacts>,
    mut started: MessageReader<CollisionStarted>,
    palette: Res<Palette>,
    play: Res<Play>,
    settings: Res<Settings>,
    mut entities: Entities,
) {
    let tick = play.tick + 1;
    // What lies on each other, or rolls on what is static, hits nothing any more.
    let lasting = contacts
        .iter()
        .map(|contact| [contact.a, contact.b])
        .filter(|both| {
            let kinds = both.map(|entity| {
                let known = entities.get(entity).ok();
                known.map(|(_, _, place, is_static, ..)| (place.is_changed(), is_static))
            });
            let has = |wanted: fn((bool, bool)) -> bool| kinds.into_iter().flatten().any(wanted);
            has(|(is_moving, _)| is_moving) && !has(|(_, is_static)| is_static)
        });
    let lasting: Vec<_> = lasting.collect();
    let begun = started.read().map(|message| [message.a, message.b]);
    for entity in lasting.into_iter().chain(begun).flatten() {
        if let Ok((.., mut painted, _)) = entities.get_mut(entity) {
            painted.hit = tick;
        }
    }
    // Where leaves are drawn, one sees why.
    let octree = index.index().engine_as::<ObjectOctree>();
    let octree = octree.filter(|_| settings.leaves != Leaves::None);
    entities.par_iter_mut().for_each(
        |(entity, proxy, place, is_static, is_sensor, is_detector, painted, mut material)| {
            let is_hit = painted.hit > 0 && painted.hit + GLOW > tick;
            let straddles = || {
                let leaves = octree
                    .zip(proxy.id())
                    .map(|(octree, id)| octree.leaves_of(id));
                leaves.is_some_and(|leaves| leaves.len() > 1)
            };
            let state = if is_sensor || is_detector {
                if contacts.of(entity).next().is_some() {
                    State::Triggered
                } else {
                    State::Sensor
                }
            } else if is_static {
                State::Static
            } else if is_hit {
                State::Hit
            } else if !place.is_changed() {
                State::Resting
            } else if straddles() {
                State::Straddling
            } else {
                State::Moving
            };
            let wanted = palette.of(state);
            if material.0 != *wanted {
                material.0 = wanted.clone();
            }
        },
    );
}
