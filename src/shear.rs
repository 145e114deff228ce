//! Shapes that their ancestors shear.
//!
//! A parent with a scale that differs by axis shears what hangs on it and is turned against it: no
//! [`Transform`] says where that is. But whatever a hierarchy does to a shape is, in this order, a
//! turn, a scale along axes, another turn and a way. The first turn is built into the shape; the
//! rest is a transform. That turn stays the same while a parent moves, turns and stretches, so that
//! a shape is built anew only when it turns against what stretches it.

use bevy::{
    math::{DAffine3, DMat3, DQuat, DVec3},
    prelude::*,
};

use crate::narrow_phase::Shape;

/// The largest cosine between two axes that counts as a right angle: what the exact tests allow for
/// rounding.
const RIGHT_ANGLE: f64 = 16.0 * f32::EPSILON as f64;
/// The length of an axis that counts as none, as a share of the longest.
const NO_LENGTH: f64 = 1e-12;
/// Axes are at right angles after four or so.
const MOST_SWEEPS: usize = 32;

/// The shape of an entity that its ancestors shear, or once did.
#[derive(Component, Clone, Debug)]
#[component(clone_behavior = Ignore)]
pub(crate) struct Sheared {
    /// The turn that is built into the shape.
    turn: DMat3,
    own: Shape,
    turned: Shape,
}

impl Sheared {
    pub(crate) fn new(own: &Shape, turn: DMat3) -> Self {
        Self {
            turn,
            own: own.clone(),
            turned: own.turned_back(&turn),
        }
    }

    /// Brings it up to date with the shape and the turn, if they are others than before.
    pub(crate) fn follow(&mut self, own: &Shape, turn: DMat3) {
        if turn != self.turn || !own.is_same(&self.own) {
            *self = Self::new(own, turn);
        }
    }

    pub(crate) const fn shape(&self) -> &Shape {
        &self.turned
    }
}

/// The shape that takes part, of an entity's own and that of its ancestors' making.
pub(crate) fn shape<'a>(own: &'a Shape, sheared: Option<&'a Sheared>) -> &'a Shape {
    sheared.map_or(own, Sheared::shape)
}

/// How a shape is put in its place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placement {
    pub(crate) transform: Transform,
    /// The turn of the shape before that.
    pub(crate) turn: DMat3,
    pub(crate) is_sheared: bool,
}

/// Puts a shape in its place in the world, after the turn that is built into it already, if that
/// will do.
pub(crate) fn put(shape: &Shape, world: &DAffine3, sheared: Option<&Sheared>) -> Placement {
    let linear = world.matrix3;
    if is_upright(&linear) {
        let transform = upright_transform(&linear, world.translation);
        return Placement {
            transform,
            turn: DMat3::IDENTITY,
            is_sheared: false,
        };
    }
    if !shape.can_turn() {
        return Placement {
            transform: unsheared(shape, world),
            turn: DMat3::IDENTITY,
            is_sheared: true,
        };
    }
    let known = sheared
        .map(|sheared| sheared.turn)
        .filter(|turn| is_upright(&(linear * *turn)));
    let turn = known.unwrap_or_else(|| upright_turn(linear));
    Placement {
        transform: upright_transform(&(linear * turn), world.translation),
        turn,
        is_sheared: true,
    }
}

/// Where a shape is that cannot be sheared: turned as is nearest to what the map does, and as long
/// along each of its own axes as that makes it.
fn unsheared(shape: &Shape, world: &DAffine3) -> Transform {
    if shape.is_rigid() {
        // As Rapier itself has it.
        return GlobalTransform::from(world.as_affine3a()).compute_transform();
    }
    let linear = world.matrix3;
    let mirror = 1f64.copysign(linear.determinant());
    let signs = DMat3::from_diagonal(DVec3::new(mirror, 1.0, 1.0));
    // A map that mirrors nothing is a stretch along some axes, and a turn.
    let turn = upright_turn(linear * signs);
    let stretched = upright_transform(&(linear * signs * turn), world.translation);
    let rotation = DMat3::from_quat(stretched.rotation.as_dquat().normalize()) * turn.transpose();
    let columns = [linear.x_axis, linear.y_axis, linear.z_axis];
    let size = DVec3::from(columns.map(DVec3::length));
    Transform {
        translation: stretched.translation,
        rotation: DQuat::from_mat3(&rotation).normalize().as_quat(),
        scale: (size * DVec3::new(mirror, 1.0, 1.0)).as_vec3(),
    }
}

/// Are the axes at right angles to each other? Those of what is not finite count as if they were.
fn is_upright(linear: &DMat3) -> bool {
    let DMat3 {
        x_axis: x,
        y_axis: y,
        z_axis: z,
    } = *linear;
    let [x_squared, y_squared, z_squared] = [x, y, z].map(DVec3::length_squared);
    let leans = |both: f64, squared: f64| both * both > RIGHT_ANGLE * RIGHT_ANGLE * squared;
    !(leans(x.dot(y), x_squared * y_squared)
        || leans(y.dot(z), y_squared * z_squared)
        || leans(z.dot(x), z_squared * x_squared))
}

/// The turn after which the axes of a map are at right angles: Jacobi rotations of two axes at a
/// time.
fn upright_turn(mut linear: DMat3) -> DMat3 {
    let mut turn = DMat3::IDENTITY;
    for _ in 0..MOST_SWEEPS {
        let mut is_done = true;
        for [i, j] in [[0, 1], [0, 2], [1, 2]] {
            let (a, b) = (linear.col(i), linear.col(j));
            let both = a.dot(b);
            if both.abs() <= f64::EPSILON * a.length() * b.length() {
                continue;
            }
            is_done = false;
            let ratio = (b.length_squared() - a.length_squared()) / (2.0 * both);
            let tangent = 1f64.copysign(ratio) / (ratio.abs() + (ratio * ratio + 1.0).sqrt());
            let cosine = (tangent * tangent + 1.0).sqrt().recip();
            let sine = cosine * tangent;
            for matrix in [&mut linear, &mut turn] {
                let (a, b) = (matrix.col(i), matrix.col(j));
                *matrix.col_mut(i) = a * cosine - b * sine;
                *matrix.col_mut(j) = a * sine + b * cosine;
            }
        }
        if is_done {
            break;
        }
    }
    turn
}

/// A map with axes at right angles, as a transform. Mirrors show in the sign of the first scale.
fn upright_transform(linear: &DMat3, translation: DVec3) -> Transform {
    let columns = [linear.x_axis, linear.y_axis, linear.z_axis];
    let mut scale = DVec3::from(columns.map(DVec3::length));
    let mut axes: [Option<DVec3>; 3] = std::array::from_fn(|i| {
        (scale[i] > NO_LENGTH * scale.max_element()).then(|| columns[i] / scale[i])
    });
    // An axis without a length is where the others leave room for it.
    while let Some(missing) = axes.iter().position(Option::is_none) {
        let (after, last) = (axes[(missing + 1) % 3], axes[(missing + 2) % 3]);
        axes[missing] = Some(match (after, last) {
            (Some(after), Some(last)) => after.cross(last),
            (Some(one), None) | (None, Some(one)) => one.any_orthonormal_vector(),
            (None, None) => DVec3::X,
        });
    }
    let [x, y, z] = axes.map(Option::unwrap_or_default);
    let mut axes = DMat3::from_cols(x, y, z);
    if axes.determinant() < 0.0 {
        axes.x_axis = -axes.x_axis;
        scale.x = -scale.x;
    }
    Transform {
        translation: translation.as_vec3(),
        rotation: DQuat::from_mat3(&axes).normalize().as_quat(),
        scale: scale.as_vec3(),
    }
}

#[cfg(test)]
mod tests;
