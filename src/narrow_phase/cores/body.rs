//! A convex shape in its place, as a core with a radius around it, in 32-bit floats.

use bevy::math::{Mat3A, Vec3, Vec3A};

use crate::narrow_phase::{
    frame::{oriented_box::OrientedBox, placed::Placed, placing::cofactors},
    mesh::convex_mesh::ConvexMesh,
    rounded::RoundedCore,
    shape::Shape,
};

/// The faces of a mesh of more are not looked at one by one.
const FEW_FACES: usize = 64;

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
    /// A cuboid along the axes of the frame.
    Upright(Vec3A),
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

/// A face of a convex mesh, as seen from a point.
#[derive(Clone, Copy, Debug)]
pub struct FaceUnder {
    pub outwards: Vec3A,
    /// How far the point is from its plane: less than nothing, if it is inside the mesh.
    pub height: f32,
    /// Is the point straight over it, or inside? Then no other point of the mesh is as close.
    pub is_over: bool,
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

    /// The axes of a cuboid.
    #[inline]
    pub const fn axes_of_cuboid(&self) -> Option<Mat3A> {
        match self.core {
            Core::Cuboid(_) => Some(self.axes),
            _ => None,
        }
    }

    /// The same in other axes, of a cuboid whose own these are, or of any shape.
    #[inline]
    pub fn along(&self, axes: &Mat3A, is_own: bool) -> Self {
        let into = axes.transpose();
        let center = into * self.center;
        if let Core::Cuboid(half) = self.core
            && is_own
        {
            return Self {
                core: Core::Upright(half),
                center,
                axes: Mat3A::IDENTITY,
                back: Mat3A::IDENTITY,
                radius: self.radius,
            };
        }
        let turned = into * self.axes;
        Self {
            core: match self.core {
                Core::Segment(half) => Core::Segment(into * half),
                Core::Triangle(corners) => Core::Triangle(corners.map(|corner| into * corner)),
                core => core,
            },
            center,
            axes: turned,
            back: turned.transpose(),
            radius: self.radius,
        }
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
            Core::Upright(half) => {
                let corner = Vec3A::select(direction.cmplt(Vec3A::ZERO), -half, half);
                return self.center + corner;
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

    /// How far the core reaches along a direction, from the origin.
    #[inline]
    pub fn reach(&self, direction: Vec3A) -> f32 {
        let from_center = match self.core {
            Core::Upright(half) => direction.abs().dot(half),
            Core::Cuboid(half) => (self.back * direction).abs().dot(half),
            Core::Hull(mesh, scale) => mesh.corners().reach(self.back * direction * scale),
            _ => return self.furthest(direction).dot(direction),
        };
        self.center.dot(direction) + from_center
    }

    /// Which face of a convex mesh is under a point, or nearest to it from inside. `None` of others,
    /// and of a scale that differs by axis.
    #[inline]
    pub fn face_under(&self, point: Vec3A) -> Option<FaceUnder> {
        let Core::Hull(mesh, scale) = self.core else {
            return None;
        };
        let size = scale.abs();
        if !(size.x == size.y && size.y == size.z && size.x > 0.0) {
            return None;
        }
        let local = self.back * (point - self.center) / scale;
        let (face, height) = mesh.corners().face_under(local);
        let face = face.min(mesh.polygon_count() - 1);
        let normal = Vec3A::from(mesh.normals()[face]);
        let is_over = height <= 0.0 || {
            let (middle, ..) = mesh.local_bounds();
            let corners = mesh.polygon(face);
            let at = |corner: u32| Vec3A::from(mesh.vertices()[corner as usize]) - middle;
            let sides = corners.iter().zip(corners.iter().cycle().skip(1));
            sides.into_iter().all(|(from, to)| {
                let from = at(*from);
                (at(*to) - from).cross(local - from).dot(normal) >= 0.0
            })
        };
        Some(FaceUnder {
            outwards: self.axes * (normal * scale.signum()),
            height: height * size.x,
            is_over,
        })
    }

    /// Is it bounded by faces, few enough to be looked at one by one?
    pub fn has_few_faces(&self) -> bool {
        self.radius == 0.0
            && match self.core {
                Core::Cuboid(_) | Core::Upright(_) => true,
                Core::Hull(mesh, _) => mesh.polygon_count() <= FEW_FACES,
                _ => false,
            }
    }

    /// Calls `visit` with the normals of all its flat faces, if it has some, and how far they are from the
    /// origin along these. What a scale of zero makes of a mesh has none.
    #[inline]
    pub fn each_face(&self, mut visit: impl FnMut(Vec3A, f32)) {
        match self.core {
            Core::Cuboid(half) | Core::Upright(half) => {
                for axis in 0..3 {
                    let normal = self.axes.col(axis);
                    let at = normal.dot(self.center);
                    visit(normal, half[axis] + at);
                    visit(-normal, half[axis] - at);
                }
            }
            Core::Hull(mesh, scale) => {
                let (middle, ..) = mesh.local_bounds();
                let cofactors = cofactors(scale);
                let is_even = cofactors.abs() == Vec3A::ONE;
                for (corners, normal) in mesh.polygons().zip(mesh.normals()) {
                    let on_face = Vec3A::from(mesh.vertices()[corners[0] as usize]) - middle;
                    let mut local = Vec3A::from(*normal) * cofactors;
                    if !is_even {
                        local = local.normalize_or_zero();
                        if local == Vec3A::ZERO {
                            continue;
                        }
                    }
                    let normal = self.axes * local;
                    visit(normal, local.dot(on_face * scale) + normal.dot(self.center));
                }
            }
            Core::Frustum {
                half_height, scale, ..
            } => {
                let normal = self.axes.y_axis;
                let (at, half) = (normal.dot(self.center), half_height * scale.y.abs());
                visit(normal, half + at);
                visit(-normal, half - at);
            }
            Core::Triangle([a, b, c]) => {
                let normal = (b - a).cross(c - a).normalize_or_zero();
                if normal != Vec3A::ZERO {
                    let at = normal.dot(self.center + a);
                    visit(normal, at);
                    visit(-normal, -at);
                }
            }
            Core::Point | Core::Segment(_) => {}
        }
    }
}

/// Its sizes are those at the largest scale of the three, so that neither a huge scale of something
/// tiny nor a tiny one of something huge is beyond the numbers.
fn frustum([top, bottom, half_height]: [f32; 3], scale: Vec3A) -> Core<'static> {
    let largest = scale.abs().max_element();
    let scale = if largest > 0.0 {
        scale / largest
    } else {
        scale
    };
    let [top, bottom, half_height] = [top, bottom, half_height].map(|size| size.abs() * largest);
    Core::Frustum {
        bottom,
        top,
        half_height,
        scale,
    }
}
