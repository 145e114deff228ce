//! What a scene is, and which one is shown.

use bevy::prelude::*;
use bevy_octree::{collision_index::CollisionIndex, motion::CollisionClock, prelude::*};

use crate::{
    play::Play,
    settings::{Leaves, Settings},
};

/// A scene of the gallery: what is spawned, and from where it is looked at.
///
/// Whatever it spawns with a [`CollisionShape`] is drawn as that shape, as far as there is a mesh of
/// it, and coloured by what happens to it; what has none is to have an [`OfScene`], so that it goes when the scene does.
/// Systems of a scene run in [`Tick`](crate::play::Tick), and [only while it is
/// shown](showing).
pub struct Scene {
    /// The word by which it is asked for.
    pub name: String,
    /// Its title in the panel.
    pub title: String,
    /// What there is to see, in a sentence or two.
    pub about: &'static str,
    /// From where it is looked at.
    view: Box<Look>,
    /// How many objects there are, where that can be chosen.
    pub objects: Option<Objects>,
    /// How many objects a leaf of the octree lists before it splits, at the start.
    pub max_objects: u32,
    /// Which leaves are drawn, at the start.
    pub leaves: Leaves,
    /// How many ticks are run for a picture where none are named.
    pub best_tick: u64,
    /// After how many ticks there is nothing more to see: it begins anew then, in the window.
    pub ends_at: Option<u64>,
    spawn: Box<Spawn>,
    /// What the scene has to say beside its counts.
    pub caption: Option<fn(&mut World) -> String>,
}

type Spawn = dyn Fn(&mut World, usize) + Send + Sync;
type Look = dyn Fn(usize) -> View + Send + Sync;

/// Where the camera is, and what it looks at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The position of the camera.
    pub eye: Vec3,
    /// The point in the middle of the picture.
    pub target: Vec3,
}

/// How many objects a scene may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Objects {
    /// At the start.
    pub default: usize,
    /// At most.
    pub most: usize,
}

impl Scene {
    /// Returns a scene that spawns what `spawn` does; its second argument is the number of objects
    /// that was chosen.
    pub fn new(
        name: impl Into<String>,
        title: impl Into<String>,
        about: &'static str,
        spawn: impl Fn(&mut World, usize) + Send + Sync + 'static,
    ) -> Self {
        Self {
            name: name.into(),
            title: title.into(),
            about,
            view: Box::new(|_| View {
                eye: Vec3::new(8.0, 6.0, 12.0),
                target: Vec3::ZERO,
            }),
            objects: None,
            max_objects: 8,
            leaves: Leaves::None,
            best_tick: 60,
            ends_at: None,
            spawn: Box::new(spawn),
            caption: None,
        }
    }

    /// Sets from where it is looked at.
    pub fn view(self, eye: Vec3, target: Vec3) -> Self {
        self.view_of(move |_| View { eye, target })
    }

    /// Sets from where it is looked at, by the number of objects.
    pub fn view_of(mut self, view: impl Fn(usize) -> View + Send + Sync + 'static) -> Self {
        self.view = Box::new(view);
        self
    }

    /// Lets the number of objects be chosen.
    pub const fn objects(mut self, default: usize, most: usize) -> Self {
        self.objects = Some(Objects { default, most });
        self
    }

    /// Sets how the octree is at the start: N, and which leaves are drawn.
    pub const fn octree(mut self, max_objects: u32, leaves: Leaves) -> Self {
        self.max_objects = max_objects;
        self.leaves = leaves;
        self
    }

    /// Sets the tick at which there is most to see.
    pub const fn best_tick(mut self, tick: u64) -> Self {
        self.best_tick = tick;
        self
    }

    /// Sets after how many ticks there is nothing more to see.
    pub const fn ends_at(mut self, tick: u64) -> Self {
        self.ends_at = Some(tick);
        self
    }

    /// Sets what the scene has to say in the panel, asked in each frame.
    pub const fn caption(mut self, caption: fn(&mut World) -> String) -> Self {
        self.caption = Some(caption);
        self
    }
}

impl Scene {
    /// Returns from where so many objects are looked at.
    pub fn view_at(&self, objects: usize) -> View {
        (self.view)(objects)
    }
}

/// Marks what a scene spawned that has no shape: it is despawned with the scene.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct OfScene;

/// All scenes, and which one is shown.
#[derive(Resource, Default)]
pub struct Gallery {
    scenes: Vec<Scene>,
    current: usize,
    reload: Option<Reload>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Reload {
    /// The same from its start, as it was set.
    Again,
    /// Another one, as it is set at its start.
    Other,
}

impl Gallery {
    /// Returns the scene that is shown.
    pub fn scene(&self) -> &Scene {
        &self.scenes[self.current]
    }

    /// Returns all scenes, in the order in which they are gone through.
    pub fn scenes(&self) -> &[Scene] {
        &self.scenes
    }

    /// Shows the scene of that name. Returns `false` if there is none.
    pub fn show(&mut self, name: &str) -> bool {
        let found = self.scenes.iter().position(|scene| scene.name == name);
        if let Some(index) = found {
            self.current = index;
            self.reload = Some(Reload::Other);
        }
        found.is_some()
    }

    /// Shows the scene that is so many after this one, or before it.
    pub fn turn(&mut self, by: isize) {
        let count = self.scenes.len().cast_signed();
        let next = (self.current.cast_signed() + by).rem_euclid(count);
        self.current = next.cast_unsigned();
        self.reload = Some(Reload::Other);
    }

    /// Begins the scene anew, as it is set now.
    pub fn restart(&mut self) {
        self.reload.get_or_insert(Reload::Again);
    }
}

/// Adds scenes to an app.
pub trait AddScene {
    /// Puts a scene behind those that are there.
    fn add_scene(&mut self, scene: Scene) -> &mut Self;
}

impl AddScene for App {
    fn add_scene(&mut self, scene: Scene) -> &mut Self {
        let world = self.world_mut();
        let mut gallery = world.get_resource_or_init::<Gallery>();
        gallery.scenes.push(scene);
        self
    }
}

/// Returns the condition that a scene is shown.
pub fn showing(name: &'static str) -> impl Fn(Res<Gallery>) -> bool + Clone {
    move |gallery| gallery.scene().name == name
}

/// A scene began.
#[derive(Event, Clone, Copy, Debug)]
pub struct Began {
    /// Whether another was shown before.
    pub is_other: bool,
}

/// Takes the last scene away and begins the next, if one was asked for.
pub fn load(world: &mut World) {
    // That nothing is asked for must not count as a change.
    let Some(reload) = world.resource::<Gallery>().reload else {
        return;
    };
    world.resource_mut::<Gallery>().reload = None;
    let is_other = reload == Reload::Other;
    let mut olds = world.query_filtered::<Entity, Or<(With<CollisionShape>, With<OfScene>)>>();
    for old in olds.iter(world).collect::<Vec<_>>() {
        // Some go with their parents.
        world.try_despawn(old).ok();
    }
    // The root of the octree is laid around what it has at first, and would be that of the scene before.
    let method = world.resource::<BroadPhaseSettings>().method.clone();
    world
        .resource_mut::<CollisionIndex>()
        .set_engine(method.engine());
    world.insert_resource(CollisionCounters::default());
    world.resource_scope(|world, gallery: Mut<Gallery>| {
        let scene = gallery.scene();
        if is_other {
            world.resource_mut::<Settings>().begin(scene);
        }
        world.resource_mut::<Play>().begin();
        world.insert_resource(CollisionClock::default());
        world.insert_resource(CollisionEventSettings::default());
        let objects = world.resource::<Settings>().objects;
        (scene.spawn)(world, objects);
    });
    world.flush();
    world.trigger(Began { is_other });
}
