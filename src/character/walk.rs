//! A step of a walk.

use bevy::prelude::*;
use smallvec::SmallVec;

use super::{
    ground::{Footing, Ground},
    settings::WalkSettings,
};
use crate::{
    move_and_slide::{
        Answer, AtHit, Crowd, Met, MoveEnd, MoveHit, Plain, Slide, Surface, Surroundings,
        along_all, project_velocity,
    },
    narrow_phase::Shape,
    spatial_query::{SpatialQuery, SpatialQueryFilter},
};

/// From so much velocity upwards on, in units per second, a character leaves the ground.
const LEAVES: f32 = 1e-3;
/// What leans less than that against the horizontal, as a sine, is no wall.
const LEVEL: f32 = 0.01;
/// Into how many parts the way to a ledge is halved.
const HALVINGS: u32 = 5;

/// What becomes of a character that walks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Walked {
    /// Where it is in the end.
    pub pose: Transform,
    /// The velocity that is left to it, in the world and apart from that of the ground: on the ground, that is along the
    /// horizontal.
    pub velocity: Vec3,
    /// What it stands on in the end, if that is ground.
    pub ground: Option<Ground>,
    /// How the move ended.
    pub end: MoveEnd,
}

/// Walks a character from a pose by a velocity, for a time in seconds: along the ground, up and down slopes and steps, on
/// platforms that move, and otherwise as [`move_and_slide`](crate::move_and_slide::move_and_slide) does.
///
/// `ground` is what it stood on at the end of the last move. Gravity is yours: take it from the velocity each time, whether on
/// the ground or not; what is against the ground is lost. A velocity upwards leaves the ground: that is how one jumps.
///
/// `on_hit` is told of all that it meets, the ground included, and decides what becomes of it. What it
/// [ignores](AtHit::Ignore) is not there for this move: a platform that may be jumped through from below is one that is
/// ignored unless its normal points up, and as long as one is in it.
///
/// What is impossible is refused, and who finds no way out is stuck, as there: see [`MoveEnd`].
///
/// Costs about two shape casts on plain ground, and three more for each step and try at one.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_octree::{character::walk, prelude::*};
///
/// #[derive(Component, Default)]
/// struct Walker {
///     velocity: Vec3,
///     ground: Option<Ground>,
/// }
///
/// fn go(mut walkers: Query<(Entity, &CollisionShape, &mut Transform, &mut Walker)>, spatial: SpatialQuery, time: Res<Time>) {
///     for (entity, shape, mut at, mut walker) in &mut walkers {
///         walker.velocity.y -= 9.8 * time.delta_secs();
///         let (filter, settings) = (spatial.filter_of(entity), WalkSettings::default());
///         let walked = walk(&spatial, shape, &at, walker.velocity, time.delta_secs(), walker.ground.as_ref(), &settings, &filter, |_| AtHit::Slide);
///         *at = walked.pose;
///         *walker = Walker { velocity: walked.velocity, ground: walked.ground };
///     }
/// }
/// # bevy::ecs::system::assert_is_system(go);
/// ```
#[expect(
    clippy::too_many_arguments,
    reason = "each is a thing of its own, and a struct for them would be one more to learn"
)]
#[doc(alias("character controller", "KinematicCharacterController"))]
pub fn walk(
    spatial: &SpatialQuery,
    shape: &Shape,
    start: &Transform,
    velocity: Vec3,
    time: f32,
    ground: Option<&Ground>,
    settings: &WalkSettings,
    filter: &SpatialQueryFilter,
    on_hit: impl FnMut(&MoveHit) -> AtHit,
) -> Walked {
    let walker = Walker {
        start: *start,
        velocity,
        time,
        ground: ground.copied(),
    };
    walker.walk(spatial, shape, settings, filter, None, on_hit)
}

/// Who walks.
#[derive(Clone, Copy, Debug)]
pub struct Walker {
    pub start: Transform,
    pub velocity: Vec3,
    pub time: f32,
    /// What it stood on.
    pub ground: Option<Ground>,
}

impl Walker {
    /// As [`walk`], among a crowd.
    pub fn walk(
        self,
        spatial: &SpatialQuery,
        shape: &Shape,
        settings: &WalkSettings,
        filter: &SpatialQueryFilter,
        crowd: Option<&dyn Crowd>,
        on_hit: impl FnMut(&MoveHit) -> AtHit,
    ) -> Walked {
        let Self {
            start,
            velocity,
            time,
            ground,
        } = self;
        let mut around = Surroundings::new(spatial, shape, filter, settings.moves.skin);
        if let Some(crowd) = crowd {
            around = around.among(crowd);
        }
        let is_possible = velocity.is_finite() && time.is_finite() && time >= 0.0;
        if !(is_possible && around.is_somewhere(&start)) {
            return Walked {
                pose: start,
                velocity: Vec3::ZERO,
                ground: None,
                end: MoveEnd::Refused,
            };
        }
        let footing = Footing::of(settings);
        let mut pose = start;
        let carried = ground.and_then(|ground| carry(&mut around, &mut pose, &ground, settings));
        let ground_velocity = match carried {
            Some(way) if time > 0.0 => way / time,
            _ => Vec3::ZERO,
        };
        let up = footing.up;
        let is_leaving = velocity.dot(up) > LEAVES;
        let stood = ground.filter(|_| !is_leaving);
        let mut step = Step {
            footing,
            settings,
            stood: stood.map(|ground| ground.point + carried.unwrap_or(Vec3::ZERO)),
            is_on_ground: stood.is_some(),
            on_hit,
        };
        let known = stood.map(|ground| Surface {
            normal: ground.normal,
            is_floor: true,
        });
        let slide = Slide {
            start: pose,
            velocity: known.map_or(velocity, |floor| along_floor(velocity, floor.normal, up)),
            time,
            most_slides: settings.moves.max_slides,
        };
        let moved = slide.along(&mut around, known, &mut step);
        let is_walking = step.is_on_ground && !is_leaving;
        let (mut pose, mut velocity, end) = (moved.pose, moved.velocity, moved.end);
        let mut found = None;
        // Who is not told of what is below falls until it meets it.
        if !is_leaving {
            let sought = if is_walking && end != MoveEnd::Stopped {
                settings.sought()
            } else {
                0.0
            };
            found = step.find_ground(&mut around, &pose, sought, velocity, time);
            let is_safe = |found: &Footed| !found.is_edge;
            if settings.stop_at_ledges && is_walking && !found.as_ref().is_some_and(is_safe) {
                let back = step.find_ledge(&mut around, (&slide.start, &pose), sought, time);
                if back.is_some() {
                    velocity = Vec3::ZERO;
                    found = back;
                }
            }
        }
        let ground = found.map(|Footed { there, ground, .. }| {
            pose = there;
            velocity = velocity.reject_from_normalized(up);
            Ground {
                velocity: if self
                    .ground
                    .is_some_and(|before| before.entity == ground.entity)
                {
                    ground_velocity
                } else {
                    Vec3::ZERO
                },
                ..ground
            }
        });
        if ground.is_none() && is_walking {
            // What went along the ground that has ended goes straight on.
            velocity = velocity.reject_from_normalized(up) + up * velocity.dot(up).min(0.0);
        }
        if end == MoveEnd::Stuck {
            velocity = Vec3::ZERO;
        }
        Walked {
            pose,
            velocity,
            ground,
            end,
        }
    }
}

/// Where one stands.
#[derive(Clone, Copy, Debug)]
struct Footed {
    there: Transform,
    ground: Ground,
    /// Is it an edge, from which one may fall?
    is_edge: bool,
}

/// A platform takes who stands on it along, as far as there is room. Returns how far.
fn carry(
    around: &mut Surroundings,
    pose: &mut Transform,
    ground: &Ground,
    settings: &WalkSettings,
) -> Option<Vec3> {
    let carried = ground.carried(around.spatial, settings.upwards())?;
    if settings.turn_with_ground {
        pose.rotation = (carried.turn * pose.rotation).normalize();
    }
    let slide = Slide {
        start: *pose,
        velocity: carried.way,
        time: 1.0,
        most_slides: settings.moves.max_slides,
    };
    let way = around.without(ground.entity, |around| {
        slide
            .along(around, None, &mut Plain(|_: &MoveHit| AtHit::Slide))
            .pose
            .translation
            - pose.translation
    });
    pose.translation += way;
    Some(way)
}

/// As fast along the horizontal, and on a floor.
fn along_floor(velocity: Vec3, normal: Vec3, up: Vec3) -> Vec3 {
    let flat = velocity.reject_from_normalized(up);
    flat - up * (normal.dot(flat) / normal.dot(up))
}

/// A step of a walk.
struct Step<'a, F> {
    footing: Footing,
    settings: &'a WalkSettings,
    /// Where its feet were on the ground.
    stood: Option<Vec3>,
    /// Is it on the ground, or has it come to it?
    is_on_ground: bool,
    on_hit: F,
}

impl<F: FnMut(&MoveHit) -> AtHit> Answer for Step<'_, F> {
    fn at(&mut self, hit: &MoveHit) -> AtHit {
        (self.on_hit)(hit)
    }

    fn is_floor(&mut self, around: &Surroundings, velocity: Vec3, met: &Met) -> bool {
        let up = self.footing.up;
        let is_ground = met.normal.dot(up) >= self.footing.flattest;
        // Who walks against an edge that is too high has a wall before it; who falls on it stands.
        let is_floor = is_ground
            || (!self.is_on_ground
                && velocity.dot(up) < 0.0
                && self.footing.normal(around, met).is_some());
        if is_floor && velocity.dot(up) <= LEAVES {
            self.is_on_ground = true;
            self.stood.get_or_insert(met.point);
        }
        is_floor
    }

    /// Floors lift, walls and slopes that are too steep stop what goes against them along the horizontal.
    fn velocity(&mut self, velocity: Vec3, surfaces: &[Surface]) -> Vec3 {
        let up = self.footing.up;
        let walls: SmallVec<[Vec3; 10]> = surfaces
            .iter()
            .filter(|surface| !surface.is_floor)
            .map(|surface| surface.normal.reject_from_normalized(up))
            .filter(|wall| wall.length() > LEVEL)
            .filter_map(Vec3::try_normalize)
            .collect();
        let flat = project_velocity(velocity.reject_from_normalized(up), &walls);
        let flat = flat.reject_from_normalized(up);
        let mut rise = velocity.dot(up);
        if self.is_on_ground {
            rise = f32::NEG_INFINITY;
        }
        for floor in surfaces.iter().filter(|surface| surface.is_floor) {
            rise = rise.max(-floor.normal.dot(flat) / floor.normal.dot(up));
        }
        if !rise.is_finite() {
            rise = velocity.dot(up).min(0.0);
        }
        // What slides down a slope, or goes against a ceiling.
        along_all(flat + up * rise, surfaces)
    }

    fn detour(
        &mut self,
        around: &Surroundings,
        pose: &Transform,
        way: Vec3,
        met: &Met,
    ) -> Option<(Transform, f32)> {
        let (up, height) = (self.footing.up, self.settings.step());
        let feet = self.stood.filter(|_| self.is_on_ground)?;
        let is_wall = met.normal.dot(up) < self.footing.flattest && met.normal.dot(up) > -0.5;
        let ahead = way.reject_from_normalized(up);
        if !(is_wall && height > around.skin && ahead.dot(met.normal) < 0.0) {
            return None;
        }
        // What is above the feet by more than a step is none.
        let above = (met.point - feet).dot(up);
        let is_round = met.normal.dot(up) > 0.0;
        if is_round && above > height + around.skin {
            return None;
        }
        let raised = around.free(pose, up * (height + around.skin));
        let rise = raised.dot(up);
        let mut there = pose.with_translation(pose.translation + raised);
        // At least as far as it is told from nothing.
        let least = 2.0 * around.skin;
        let far = ahead.length();
        let forward = ahead * (far.max(least) / far);
        let gone = around.free(&there, forward);
        if rise <= around.skin || gone.length() < 0.5 * far.min(around.skin) {
            return None;
        }
        there.translation += gone;
        let down = -up * (rise + around.skin);
        let below = around.cast(&there, down)?;
        self.footing.normal(around, &below)?;
        if (below.point - feet).dot(up) > height + 2.0 * around.skin {
            return None;
        }
        there.translation += down * below.share;
        let climbed = (there.translation - pose.translation).dot(up);
        (climbed > 0.0).then(|| (there, (gone.length() / far).min(1.0)))
    }
}

impl<F: FnMut(&MoveHit) -> AtHit> Step<'_, F> {
    /// Finds ground below, no further than that, and where one stands on it.
    fn find_ground(
        &mut self,
        around: &mut Surroundings,
        pose: &Transform,
        sought: f32,
        velocity: Vec3,
        time: f32,
    ) -> Option<Footed> {
        let up = self.footing.up;
        let down = -up * (sought + 2.0 * around.skin);
        let met = loop {
            let met = around.cast(pose, down)?;
            if (self.on_hit)(&met.hit(time, velocity)) != AtHit::Ignore {
                break met;
            }
            around.ignore(met.entity);
        };
        let normal = self.footing.normal(around, &met)?;
        let mut there = pose.with_translation(pose.translation + down * met.share);
        if met.share == 0.0 && met.gap < 0.5 * around.skin {
            there.translation += around.free(&there, up * (around.skin - met.gap));
        }
        let ground = Ground {
            entity: met.entity,
            point: met.point,
            normal,
            velocity: Vec3::ZERO,
            pose: around.spatial.entry_of(met.entity)?.pose,
        };
        Some(Footed {
            there,
            ground,
            is_edge: met.normal.dot(up) < self.footing.flattest,
        })
    }

    /// Finds how far one may go before there is no ground any more, but an edge.
    fn find_ledge(
        &mut self,
        around: &mut Surroundings,
        (from, to): (&Transform, &Transform),
        sought: f32,
        time: f32,
    ) -> Option<Footed> {
        let way = (to.translation - from.translation).reject_from_normalized(self.footing.up);
        let (mut safe, mut far) = (0.0, 1.0);
        let mut best = None;
        for _ in 0..HALVINGS {
            let middle = if best.is_none() {
                safe
            } else {
                (safe + far) / 2.0
            };
            let there = to.with_translation(from.translation + way * middle);
            let found = self.find_ground(around, &there, sought, Vec3::ZERO, time);
            match found {
                Some(found) if best.is_none() || !found.is_edge => {
                    best = Some(found);
                    safe = middle;
                }
                _ if best.is_none() => return None,
                _ => far = middle,
            }
        }
        best
    }
}
