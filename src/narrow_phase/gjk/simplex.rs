//! Up to four points of a difference, and which point of their hull is closest to the origin.
//!
//! By the regions of sides and planes that the origin is over (Ericson, *Real-Time Collision
//! Detection*, 2005, section 9.5). What had been looked at before the last point came is not looked
//! at again: what is closest has that point.

use bevy::math::{DVec3, Vec3A};

use super::vector::{Scalar, Vector};

/// A point of the difference of two shapes, and of which points it is that.
#[derive(Clone, Copy, Debug)]
pub struct Vertex<V> {
    pub point: V,
    pub on: [V; 2],
}

impl<V: Vector> Vertex<V> {
    /// That of two points.
    #[inline(always)]
    pub fn of(on: [V; 2]) -> Self {
        Self {
            point: on[0] - on[1],
            on,
        }
    }
}

/// Up to four points of the difference, with the weights that make up the point of their hull
/// closest to the origin.
#[derive(Clone, Copy, Debug)]
pub struct Simplex<V: Vector> {
    vertices: [Vertex<V>; 4],
    weights: [V::Scalar; 4],
    count: usize,
}

/// Those of some points whose hull has the point closest to the origin, with their weights, and the
/// square of its distance.
#[derive(Clone, Copy)]
struct Nearest<V: Vector, const N: usize> {
    weights: [V::Scalar; N],
    squared: V::Scalar,
}

impl<V: Vector> Simplex<V> {
    #[inline]
    pub fn new(vertex: Vertex<V>) -> Self {
        let (zero, one) = (V::Scalar::ZERO, V::Scalar::ONE);
        Self {
            vertices: [vertex; 4],
            weights: [one, zero, zero, zero],
            count: 1,
        }
    }

    #[inline]
    pub fn vertices(&self) -> &[Vertex<V>] {
        debug_assert!((1..=4).contains(&self.count), "{} vertices", self.count);
        &self.vertices[..self.count]
    }

    #[inline(always)]
    fn weighted(&self, of: impl Fn(&Vertex<V>) -> V) -> V {
        let weighted = |i: usize| of(&self.vertices[i]) * self.weights[i];
        (1..self.count).fold(weighted(0), |sum, i| sum + weighted(i))
    }

    /// The point of the hull that is closest to the origin.
    #[inline]
    pub fn nearest(&self) -> V {
        self.weighted(|vertex| vertex.point)
    }

    /// The points of the two shapes that it comes from.
    #[inline]
    pub fn points(&self) -> [V; 2] {
        [
            self.weighted(|vertex| vertex.on[0]),
            self.weighted(|vertex| vertex.on[1]),
        ]
    }

    /// With one more vertex, and without those that are then no use; `None` if the hull has the
    /// origin inside.
    #[inline]
    pub fn with(&self, vertex: Vertex<V>) -> Option<Self> {
        let zero = V::Scalar::ZERO;
        let point = |i: usize| self.vertices[i].point;
        let d = vertex.point;
        // The weight of the last is the last.
        let (weights, last) = match self.count {
            1 => {
                let [a, d] = segment([point(0), d]).weights;
                ([a, zero, zero], d)
            }
            2 => {
                let [a, b, d] = triangle([point(0), point(1), d]).weights;
                ([a, b, zero], d)
            }
            _ => {
                let [a, b, c, d] = tetrahedron([point(0), point(1), point(2), d])?;
                ([a, b, c], d)
            }
        };
        let mut kept = *self;
        kept.count = 0;
        for (i, weight) in weights.into_iter().enumerate().take(self.count) {
            if weight > zero {
                (kept.vertices[kept.count], kept.weights[kept.count]) = (self.vertices[i], weight);
                kept.count += 1;
            }
        }
        if last > zero || kept.count == 0 {
            (kept.vertices[kept.count], kept.weights[kept.count]) = (vertex, last);
            kept.count += 1;
        }
        Some(kept)
    }

    /// The hull with one more vertex, which has the origin inside.
    pub fn enclosing(&self, vertex: Vertex<V>) -> Self {
        let mut all = *self;
        all.vertices[3] = vertex;
        all.count = 4;
        let quarter = V::Scalar::ONE / (V::Scalar::ONE + V::Scalar::ONE);
        let quarter = quarter * quarter;
        all.weights = inside(all.vertices.map(|vertex| vertex.point)).unwrap_or([quarter; 4]);
        all
    }
}

impl Simplex<Vec3A> {
    /// The same in 64-bit floats.
    pub fn wide(&self) -> Simplex<DVec3> {
        Simplex {
            vertices: self.vertices.map(|vertex| Vertex {
                point: vertex.point.as_dvec3(),
                on: vertex.on.map(|point| point.as_dvec3()),
            }),
            weights: self.weights.map(f64::from),
            count: self.count,
        }
    }
}

/// The point of a segment that is closest to the origin.
#[inline(always)]
fn segment<V: Vector>([a, b]: [V; 2]) -> Nearest<V, 2> {
    let (zero, one) = (V::Scalar::ZERO, V::Scalar::ONE);
    let along = b - a;
    let squared = along.length_squared();
    let share = if squared > zero {
        (-a.dot(along) / squared).clamped(zero, one)
    } else {
        zero
    };
    let weights = [one - share, share];
    Nearest {
        weights,
        squared: (a * weights[0] + b * weights[1]).length_squared(),
    }
}

/// The point of a triangle that is closest to the origin, and has something of the last corner.
#[inline]
pub(super) fn triangle_weights<V: Vector>(corners: [V; 3]) -> [V::Scalar; 3] {
    triangle(corners).weights
}

#[inline]
fn triangle<V: Vector>([a, b, c]: [V; 3]) -> Nearest<V, 3> {
    let zero = V::Scalar::ZERO;
    let normal = (a - c).cross(b - c);
    let squared = normal.length_squared();
    let areas = [
        b.cross(c).dot(normal),
        c.cross(a).dot(normal),
        a.cross(b).dot(normal),
    ];
    let whole = areas[0] + areas[1] + areas[2];
    if squared > zero && whole > zero && areas.iter().all(|area| *area >= zero) {
        let height = a.dot(normal);
        return Nearest {
            weights: areas.map(|area| area / whole),
            squared: height / squared * height,
        };
    }
    let (one, other) = (segment([a, c]), segment([b, c]));
    if one.squared <= other.squared {
        let [at_a, at_c] = one.weights;
        Nearest {
            weights: [at_a, zero, at_c],
            squared: one.squared,
        }
    } else {
        let [at_b, at_c] = other.weights;
        Nearest {
            weights: [zero, at_b, at_c],
            squared: other.squared,
        }
    }
}

/// The weights of the point of a tetrahedron that is closest to the origin; `None` if that is
/// inside.
#[inline]
fn tetrahedron<V: Vector>(points: [V; 4]) -> Option<[V::Scalar; 4]> {
    let zero = V::Scalar::ZERO;
    let [a, b, c, d] = points;
    let [u, v, w] = [a - d, b - d, c - d];
    let normals = [v.cross(w), w.cross(u), u.cross(v)];
    let volume = u.dot(normals[0]);
    let longest = u
        .length_squared()
        .greater(v.length_squared())
        .greater(w.length_squared());
    let is_flat = volume.greater(-volume) <= V::Scalar::FLAT * longest * longest.sqrt();
    // How much of each corner the origin has, but for the last.
    let shares = normals.map(|normal| -d.dot(normal) / volume);
    let is_inside = shares.iter().all(|share| *share >= zero)
        && shares[0] + shares[1] + shares[2] <= V::Scalar::ONE;
    if is_inside && !is_flat {
        return None;
    }
    // The sides that it is beyond, and those that rounding may have it beyond.
    let is_beyond = |share: V::Scalar| is_flat || !(share > V::Scalar::DOUBT);
    let mut beyond = shares.map(is_beyond);
    if beyond == [false; 3] {
        beyond = [true; 3];
    }
    let mut best: Option<Nearest<V, 4>> = None;
    let mut consider = |weights: [V::Scalar; 4], squared: V::Scalar| {
        if best.is_none_or(|best| squared < best.squared) {
            best = Some(Nearest { weights, squared });
        }
    };
    if beyond[0] {
        let Nearest {
            weights: [b, c, d],
            squared,
        } = triangle([b, c, d]);
        consider([zero, b, c, d], squared);
    }
    if beyond[1] {
        let Nearest {
            weights: [c, a, d],
            squared,
        } = triangle([c, a, d]);
        consider([a, zero, c, d], squared);
    }
    if beyond[2] {
        let Nearest {
            weights: [a, b, d],
            squared,
        } = triangle([a, b, d]);
        consider([a, b, zero, d], squared);
    }
    Some(best.map_or([zero, zero, zero, V::Scalar::ONE], |best| best.weights))
}

/// The weights of the origin, if it is inside a tetrahedron that is not flat.
fn inside<V: Vector>([a, b, c, d]: [V; 4]) -> Option<[V::Scalar; 4]> {
    let zero = V::Scalar::ZERO;
    let [u, v, w] = [b - a, c - a, d - a];
    let volume = u.cross(v).dot(w);
    let [to_b, to_c, to_d] =
        [v.cross(w), w.cross(u), u.cross(v)].map(|normal| -a.dot(normal) / volume);
    let weights = [V::Scalar::ONE - to_b - to_c - to_d, to_b, to_c, to_d];
    weights
        .iter()
        .all(|weight| *weight >= zero)
        .then_some(weights)
}
