//! All characters walk, side by side.

use bevy::{
    ecs::{entity::EntityHashMap, query::QueryData},
    math::DAffine3,
    prelude::*,
};
use smallvec::SmallVec;

use super::{
    component::{CharacterHits, KinematicCharacter},
    gone::Gone,
    walk::Walker,
};
use crate::{
    ancestors,
    broad_phase::ProxyId,
    collision_index::CollisionIndex,
    components::{BroadPhaseProxy, CollisionShape, WorldAabb},
    filters::{IgnoreCollisions, ignore_each_other},
    hierarchy::{self, Link},
    motion::MotionSettings,
    move_and_slide::{AtHit, Crowd},
    narrow_phase::{NarrowPhase, Placed},
    parallel,
    shear::{self, Sheared},
    spatial_query::SpatialQuery,
};

type Reaching<'a> = (
    &'a KinematicCharacter,
    (&'a CollisionShape, Option<&'a Sheared>),
    &'a BroadPhaseProxy,
    &'a mut WorldAabb,
);

/// Enlarges the box of each character by as far as it may go in this tick, so that nobody misses it where it gets to.
pub(super) fn reach(
    mut characters: Query<Reaching>,
    mut index: ResMut<CollisionIndex>,
    (tests, settings): (Res<NarrowPhase>, Res<MotionSettings>),
    time: Option<Res<Time>>,
) {
    let seconds = settings.step.seconds(time.as_deref()).unwrap_or(0.0);
    for (character, (shape, sheared), proxy, mut aabb) in &mut characters {
        let shape = shear::shape(shape, sheared);
        let Ok(mut around) = tests.world_aabb(Placed::new(shape, proxy.pose())) else {
            continue;
        };
        let way = character.velocity.length() * seconds;
        let walk = &character.settings;
        let reach = way + walk.step() + walk.sought() + 4.0 * walk.moves.skin.max(0.0);
        if reach.is_finite() {
            around.min -= reach;
            around.max += reach;
        }
        *aabb = WorldAabb(around);
        if let Some(id) = proxy.id() {
            index.look_again(id);
        }
    }
}

/// Where the others are to go in this tick.
#[derive(Default)]
pub(super) struct Others {
    /// By proxy index.
    ways: Vec<Option<Vec3>>,
    reach: f32,
}

impl Others {
    fn clear(&mut self) {
        self.ways.clear();
        self.reach = 0.0;
    }

    fn add(&mut self, id: ProxyId, way: Vec3) {
        let way = if way.is_finite() { way } else { Vec3::ZERO };
        if self.ways.len() <= id.index() {
            self.ways.resize(id.index() + 1, None);
        }
        self.ways[id.index()] = Some(way);
        self.reach = self.reach.max(way.length());
    }
}

impl Crowd for Others {
    fn way(&self, id: ProxyId) -> Option<Vec3> {
        *self.ways.get(id.index())?
    }

    fn reach(&self) -> f32 {
        self.reach
    }
}

type Walking<'a> = (
    Entity,
    (&'a CollisionShape, Option<&'a Sheared>),
    &'a BroadPhaseProxy,
    &'a mut KinematicCharacter,
    &'a mut Gone,
    Option<&'a mut CharacterHits>,
);

/// Each sees the others where they were at the start of the tick, and where they are to go: the outcome depends on no order.
pub(super) fn walk(
    mut characters: Query<Walking>,
    spatial: SpatialQuery,
    ignored: Query<&IgnoreCollisions>,
    parents: Query<&ChildOf>,
    settings: Res<MotionSettings>,
    time: Option<Res<Time>>,
    mut others: Local<Others>,
) {
    let seconds = settings.step.seconds(time.as_deref()).unwrap_or(0.0);
    others.clear();
    for (_, _, proxy, character, ..) in &characters {
        if let Some(id) = proxy.id() {
            others.add(id, character.velocity * seconds);
        }
    }
    let others = &*others;
    let step = |(entity, (shape, sheared), proxy, mut character, mut gone, hits): WalkingItem| {
        gone.0 = None;
        // Who is not in the index is nowhere.
        if proxy.id().is_none() {
            return;
        }
        let mut ground = character.ground;
        if let Some(ground) = &mut ground
            && hangs_on(entity, ground.entity, &parents)
            && let Some(body) = spatial.entry_of(ground.entity)
        {
            // Its parent has taken it along already.
            ground.pose = body.pose;
        }
        let is_met = |other| !ignore_each_other([entity, other], |one| ignored.get(one).ok());
        let filter = spatial.filter_of(entity);
        let filter = if ignored.is_empty() {
            filter
        } else {
            filter.only(&is_met)
        };
        let mut hits = hits.map(Mut::into_inner);
        if let Some(hits) = &mut hits {
            hits.0.clear();
        }
        let walker = Walker {
            start: *proxy.pose(),
            velocity: character.velocity,
            time: seconds,
            ground,
        };
        let shape = shear::shape(shape, sheared);
        let walked = walker.walk(
            &spatial,
            shape,
            &character.settings,
            &filter,
            Some(others),
            |hit| {
                if let Some(hits) = &mut hits {
                    hits.0.push(*hit);
                }
                AtHit::Slide
            },
        );
        let after = KinematicCharacter {
            velocity: walked.velocity,
            ground: walked.ground,
            end: walked.end,
            ..*character
        };
        character.set_if_neq(after);
        gone.0 = (walked.pose != walker.start).then_some(walked.pose);
    };
    if parallel::is_on() {
        characters.par_iter_mut().for_each(step);
    } else {
        characters.iter_mut().for_each(step);
    }
}

type WalkingItem<'a, 'w, 's> = <Walking<'a> as QueryData>::Item<'w, 's>;

/// Is one of the ancestors of an entity that one?
fn hangs_on(entity: Entity, ancestor: Entity, parents: &Query<&ChildOf>) -> bool {
    let parent = |entity| parents.get(entity).ok().map(ChildOf::parent);
    let look = |entity| Some((entity, parent(entity)));
    parent(entity).is_some_and(|first| {
        ancestors::up(first, look)
            .map_while(Result::ok)
            .any(|entity| entity == ancestor)
    })
}

type Settled<'a> = (
    &'a Gone,
    &'a mut Transform,
    &'a mut BroadPhaseProxy,
    Option<&'a ChildOf>,
);

/// What hangs on what, and who has gone somewhere.
type Both<'w, 's> = ParamSet<
    'w,
    's,
    (
        Query<'static, 'static, Link<'static>>,
        Query<'static, 'static, Settled<'static>>,
    ),
>;

/// Puts all where they have come to: in their own spaces, and in the index. What is disabled is not in that, and stays.
pub(super) fn settle(
    mut both: Both,
    mut index: ResMut<CollisionIndex>,
    tests: Res<NarrowPhase>,
    mut parents: Local<EntityHashMap<DAffine3>>,
) {
    parents.clear();
    let hang: SmallVec<[Entity; 8]> = both
        .p1()
        .iter()
        .filter(|(gone, ..)| gone.0.is_some())
        .filter_map(|(.., parent)| parent.map(ChildOf::parent))
        .collect();
    for parent in hang {
        if let Some(pose) = hierarchy::pose_in_world(parent, &both.p0()) {
            parents.insert(parent, pose.inverse());
        }
    }
    let mut is_beyond = false;
    for (gone, mut transform, mut proxy, parent) in &mut both.p1() {
        let (Some(pose), Some(id)) = (gone.0, proxy.id()) else {
            continue;
        };
        let before = *proxy.pose();
        match parent.map(ChildOf::parent) {
            None => {
                transform.translation = pose.translation;
                transform.rotation = pose.rotation;
            }
            Some(parent) => {
                let to_own = parents.get(&parent).filter(|to_own| to_own.is_finite());
                let Some(to_own) = to_own else {
                    continue;
                };
                // What it has turned in the world, it turns in the space of its parent.
                let turned = pose.rotation.as_dquat() * before.rotation.as_dquat().inverse();
                let way = (pose.translation - before.translation).as_dvec3();
                transform.translation += to_own.transform_vector3(way).as_vec3();
                let (_, turn, _) = to_own.to_scale_rotation_translation();
                let own = turn * turned * turn.inverse();
                transform.rotation = (own * transform.rotation.as_dquat()).normalize().as_quat();
            }
        }
        BroadPhaseProxy::note_pose(&mut proxy, pose);
        if !index.move_within(id, &pose, &tests) {
            index.put(id, &pose, &tests);
            is_beyond = true;
        }
    }
    if is_beyond {
        index.settle();
    }
}
