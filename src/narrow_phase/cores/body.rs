//! A convex shape in its place, as a core with a radius around it, in 32-bit floats.

use bevy::math::{Mat3A, Vec3, Vec3A};

use crate::narrow_phase::{
    frame::{oriented_box::OrientedBox, placed::Placed},
    mesh::convex_mesh::ConvexMesh,
    rounded::RoundedCore,
    shape::Shape,
};

/// What a convex shape consists of, but for a radius around it.
#[derive(Clone, Copy, Debug)]
pub enum Core<'a> {
    Point,
    /// By its half, in the frame of the pair.
    Segment(Vec3A),
    /// By its corners around the centre, in the frame of the pair.
    Triangle([Vec3A; 3]),
    /// By half its sides.
    Cuboid(Vec3A),
    /// Around the second axis: a cylinder or a cone, too. Elliptic, if its scale differs across.
    Frustum {
        bottom: f32,
        top: f32,
        half_height: f32,
        scale: Vec3A,
    },
    Hull(&'a ConvexMesh, Vec3A),
}

/// A convex shape in the frame of a pair.
#[derive(Clone, Copy, Debug)]
pub struct Body<'a> {
    pub core: Core<'a>,
    /// Of the core.
    pub center: Vec3A,
    pub axes: Mat3A,
    /// The way back to the own axes.
    back: Mat3A,
    /// All that is no further from the core is part of the shape.
    pub radius: f32,
}

impl<'a> Body<'a> {
    /// Takes a shape as its core, given the box around it; `None` if it is not convex, or has no end.
    #[inline]
    pub fn of(placed: Placed<'a>, bounds: &OrientedBox) -> Option<Self> {
        let scale = Vec3A::from(placed.transform.scale);
        let axes = bounds.axes;
        let new = |core: Core<'a>, radius: f32| Self {
            core,
            center: bounds.center,
            axes,
            back: axes.transpose(),
            radius,
        };
        Some(match placed.shape {
            Shape::Sphere { .. } => new(Core::Point, bounds.radius),
            Shape::Cuboid { .. } => new(Core::Cuboid(bounds.half), 0.0),
            Shape::Capsule { .. } => {
                let radius = bounds.half.x;
                new(
                    Core::Segment(axes.y_axis * (bounds.half.y - radius)),
                    radius,
                )
            }
            Shape::ConicalFrustum {
                radius_top,
                radius_bottom,
                half_height,
            } => new(
                frustum([*radius_top, *radius_bottom, *half_height], scale),
                0.0,
            ),
            Shape::Convex(mesh) => new(Core::Hull(mesh, scale), 0.0),
            Shape::Rounded(rounded) => {
                let radius = rounded.radius() * scale.abs().max_element();
                let (middle, half, _) = rounded.core_bounds();
                let place = |point: Vec3| axes * ((Vec3A::from(point) - middle) * scale);
                let core = match rounded.core() {
                    RoundedCore::Segment([from, to]) => {
                        Core::Segment((place(*to) - place(*from)) * 0.5)
                    }
                    RoundedCore::Triangle(corners) => Core::Triangle(corners.map(place)),
                    RoundedCore::Cuboid { .. } => Core::Cuboid((half * scale).abs()),
                    RoundedCore::ConicalFrustum {
                        radius_top,
                        radius_bottom,
                        half_height,
                    } => frustum([*radius_top, *radius_bottom, *half_height], scale),
                    RoundedCore::Convex(mesh) => Core::Hull(mesh, scale),
                };
                new(core, radius)
            }
            _ => return None,
        })
    }

    /// The point of the core that is furthest along a direction.
    #[inline]
    pub fn furthest(&self, direction: Vec3A) -> Vec3A {
        let local = match self.core {
            Core::Point => return self.center,
            Core::Segment(half) => {
                let end = if half.dot(direction) < 0.0 {
                    -half
                } else {
                    half
                };
                return self.center + end;
            }
            Core::Triangle(corners) => {
                let [a, b, c] = corners.map(|corner| corner.dot(direction));
                let furthest = if a >= b && a >= c {
                    0
                } else if b >= c {
                    1
                } else {
                    2
                };
                return self.center + corners[furthest];
            }
            Core::Cuboid(half) => {
                let direction = self.back * direction;
                Vec3A::select(direction.cmplt(Vec3A::ZERO), -half, half)
            }
            Core::Frustum {
                bottom,
                top,
                half_height,
                scale,
            } => {
                let direction = self.back * direction * scale;
                let across = direction.with_y(0.0);
                let steep = across.length();
                let (low, high) = (bottom * steep, top * steep);
                let rise = half_height * direction.y;
                let (radius, y) = if high + rise > low - rise {
                    (top, half_height)
                } else {
                    (bottom, -half_height)
                };
                let outwards = if steep > f32::MIN_POSITIVE {
                    across * (radius / steep)
                } else {
                    Vec3A::ZERO
                };
                outwards.with_y(y) * scale
            }
            Core::Hull(mesh, scale) => {
                mesh.corners().furthest(self.back * direction * scale) * scale
            }
        };
        self.center + self.axes * local
    }

    /// The way out of a convex mesh for a point inside: that through the nearest of its faces. A unit
    /// vector, and how far. `None` of others, and of a scale that differs by axis.
    pub fn way_out(&self, point: Vec3A) -> Option<(Vec3A, f32)> {
        let Core::Hull(mesh, scale) = self.core else {
            return None;
        };
        let size = scale.abs();
        if !(size.x == size.y && size.y == size.z && size.x > 0.0) {
            return None;
        }
        let (middle, ..) = mesh.local_bounds();
        let local = self.back * (point - self.center) / scale + middle;
        let faces = mesh.polygons().zip(mesh.normals());
        let heights = faces.map(|(corners, normal)| {
            let on_face = Vec3A::from(mesh.vertices()[corners[0] as usize]);
            let normal = Vec3A::from(*normal);
            (normal, normal.dot(local - on_face))
        });
        let (normal, height) = heights.max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some((self.axes * (normal * scale.signum()), -height * size.x))
    }
}

fn frustum([top, bottom, half_height]: [f32; 3], scale: Vec3A) -> Core<'static> {
    Core::Frustum {
        bottom: bottom.abs(),
        top: top.abs(),
        half_height: half_height.abs(),
        scale,
    }
}
