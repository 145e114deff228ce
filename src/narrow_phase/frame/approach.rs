//! Whether two that move come nearer to each other.

use bevy::math::Vec3;

/// The share of a velocity along a normal that is more than rounding.
const APPROACH: f64 = 1e-6;

/// Do two come nearer to each other along a normal from the first to the second? More so than
/// rounding would have them.
pub(crate) fn approach(velocities: [Vec3; 2], normal: Vec3) -> bool {
    // In 64 bits, for the squares of the largest velocities are beyond 32.
    let velocity = velocities[0].as_dvec3() - velocities[1].as_dvec3();
    velocity.dot(normal.as_dvec3()) > APPROACH * velocity.length()
}
