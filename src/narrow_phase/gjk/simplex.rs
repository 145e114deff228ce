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

/// The weights of up to three vertices, and of one more.
type With<V> = ([<V as Vector>::Scalar; 3], <V as Vector>::Scalar);

/// What one more vertex brings.
pub enum Step<V: Vector> {
    Nearer {
        nearest: V,
        distance: V::Scalar,
    },
    None,
    /// The origin is in the hull.
    Inside,
}

/// Those of some points whose hull has the point closest to the origin, with their weights, and the
/// square of its distance.
#[derive(Clone, Copy)]
struct Nearest<V: Vector, const N: usize> {
    weights: [V::Scalar; N],
    squared: V::Scalar,
}

impl<V: Vector> Simplex<V> {
    /// One of nothing.
    pub fn empty() -> Self {
        let zero = V::ZERO;
        Self::new(Vertex::of([zero, zero]))
    }

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

    /// The weights of the point closest to the origin with one more vertex: those of the others, and
    /// then that of the new one. An error with all four, if the hull has the origin inside.
    #[inline(always)]
    fn weights_with(&self, point: V) -> Result<With<V>, [V::Scalar; 4]> {
        let zero = V::Scalar::ZERO;
        let [a, b, c, _] = self.vertices.each_ref().map(|vertex| vertex.point);
        Ok(match self.count {
            1 => {
                let [a, d] = segment([a, point]).weights;
                ([a, zero, zero], d)
            }
            2 => {
                let [a, b, d] = triangle([a, b, point]).weights;
                ([a, b, zero], d)
            }
            _ => {
                let [a, b, c, d] = tetrahedron([a, b, c, point])?;
                ([a, b, c], d)
            }
        })
    }

    /// Adds a vertex if that brings the hull closer to the origin than `distance`, or has it inside, and
    /// drops those that are then no use.
    #[inline]
    pub fn add(&mut self, vertex: &Vertex<V>, distance: V::Scalar) -> Step<V> {
        let (weights, last) = match self.weights_with(vertex.point) {
            Ok(weights) => weights,
            Err(all) => {
                self.vertices[3] = *vertex;
                self.weights = all;
                self.count = 4;
                return Step::Inside;
            }
        };
        let mut nearest = vertex.point * last;
        for (vertex, weight) in self.vertices.iter().zip(weights).take(self.count) {
            nearest = nearest + vertex.point * weight;
        }
        let next = nearest.length();
        // A step that is none would be made over and over.
        let is_nearer = next < distance;
        if !is_nearer {
            return Step::None;
        }
        let mut kept = 0;
        for (i, weight) in weights.into_iter().enumerate().take(self.count) {
            if weight > V::Scalar::ZERO {
                if kept != i {
                    self.vertices[kept] = self.vertices[i];
                }
                self.weights[kept] = weight;
                kept += 1;
            }
        }
        if kept < 4 && (last > V::Scalar::ZERO || kept == 0) {
            self.vertices[kept] = *vertex;
            self.weights[kept] = last;
            kept += 1;
        }
        self.count = kept;
        Step::Nearer {
            nearest,
            distance: next,
        }
    }
}

impl Simplex<Vec3A> {
    /// The same in 64-bit floats.
    pub fn wide(&self) -> Simplex<DVec3> {
        Simplex {
            vertices: self.vertices.map(|vertex| Vertex {
                point: vertex.point.as_dvec3(),
                on: vertex.on.map(Vec3A::as_dvec3),
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
        let weights = areas.map(|area| area / whole);
        // By what the weights make, not by the plane: that of a triangle without an area is noise.
        let nearest = a * weights[0] + b * weights[1] + c * weights[2];
        return Nearest {
            weights,
            squared: nearest.length_squared(),
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

/// The weights of the point of a tetrahedron that is closest to the origin; those of the origin as an
/// error, if it is inside.
#[inline]
fn tetrahedron<V: Vector>(points: [V; 4]) -> Result<[V::Scalar; 4], [V::Scalar; 4]> {
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
    let last = V::Scalar::ONE - shares[0] - shares[1] - shares[2];
    let is_inside = last >= zero && shares.iter().all(|share| *share >= zero);
    if is_inside && !is_flat {
        let [a, b, c] = shares;
        return Err([a, b, c, last]);
    }
    // The sides that it is beyond, and those that rounding may have it beyond.
    let is_before = |share: V::Scalar| share > V::Scalar::DOUBT;
    let mut beyond = shares.map(|share| is_flat || !is_before(share));
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
    Ok(best.map_or([zero, zero, zero, V::Scalar::ONE], |best| best.weights))
}
