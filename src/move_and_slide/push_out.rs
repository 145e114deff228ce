//! Out of what a shape is in.

use bevy::{math::DVec3, prelude::*};
use smallvec::SmallVec;

use super::{
    hit::Depenetrated,
    planes::{self, Plane, Planes},
    surroundings::{ROUNDING, Surroundings, Touch},
};

/// So often is looked whether all is well where the last push has led.
const MOST_PUSHES: usize = 16;

/// How deep counts as in something, in skins: less is what rounding makes of touching.
const DEEP: f32 = 1e-3;

/// Pushes a shape out of all that it is in, and asks about each of these once, before the first push.
///
/// Contacts at a place say which way to go at least: `normal · way >= depth`. The shortest way that does as all of them say
/// leads to the next place, where there may be others, and those of before still hold, as they do in a narrow corner. Where
/// they contradict each other, as those of round things may, the newest count.
pub fn push_out(
    around: &mut Surroundings,
    start: &Transform,
    mut admits: impl FnMut(&Touch) -> bool,
) -> Depenetrated {
    let (mut pose, mut planes) = (*start, Planes::new());
    let mut asked: SmallVec<[Entity; 8]> = SmallVec::new();
    let slack = DEEP * around.skin + ROUNDING * start.translation.abs().max_element();
    for round in 0..MOST_PUSHES {
        let mut touches: SmallVec<[Touch; 8]> = SmallVec::new();
        around.for_each_touch(&pose, |touch| touches.push(touch));
        // In an order that does not depend on handles.
        touches.sort_unstable_by_key(|touch| around.spatial.order_of(touch.entity));
        touches.retain(|touch| {
            if asked.contains(&touch.entity) {
                return true;
            }
            asked.push(touch.entity);
            let is_admitted = admits(touch);
            if !is_admitted {
                around.ignore(touch.entity);
            }
            is_admitted
        });
        // Who gives way by half has been given its half.
        touches.retain(|touch| round == 0 || touch.share == 1.0);
        if touches.iter().all(|touch| touch.depth <= slack) {
            return Depenetrated {
                pose,
                is_free: true,
            };
        }
        let here = (pose.translation - start.translation).as_dvec3();
        let of = |touch: &Touch| {
            let normal = touch.normal.as_dvec3();
            let off = f64::from((touch.depth + around.skin) * touch.share);
            Plane {
                normal,
                offset: normal.dot(here) + off,
            }
        };
        touches
            .iter()
            .for_each(|touch| planes::add(&mut planes, of(touch)));
        let way = planes::shortest(&planes).or_else(|| {
            planes.clear();
            touches
                .iter()
                .for_each(|touch| planes::add(&mut planes, of(touch)));
            planes::shortest(&planes)
        });
        let Some(way) = way else {
            break;
        };
        let push = (way - here).as_vec3();
        if push == Vec3::ZERO {
            break;
        }
        pose.translation += push_through(around, &pose, push, &mut planes, here);
    }
    Depenetrated {
        pose: *start,
        is_free: false,
    }
}

/// How far the shape may be pushed, without going through what it is not in. What is in the way, counts from then on.
fn push_through(
    around: &mut Surroundings,
    pose: &Transform,
    push: Vec3,
    planes: &mut Planes,
    here: DVec3,
) -> Vec3 {
    let Some(met) = around.cast_past(pose, push) else {
        return push;
    };
    let (normal, way) = (met.normal.as_dvec3(), push * met.share);
    let offset = normal.dot(here + way.as_dvec3());
    planes::add(planes, Plane { normal, offset });
    way
}
