//! What lies on parts whose surfaces are one plane, as the cells of a floor: where two of them join,
//! there are corners of pieces that are none of the whole.

use bevy::math::{DVec3, Vec2, Vec3A};

use super::patch::{Patch, PatchPoint};

/// The cosine of the angle up to which two planes are one.
const ALIKE: f64 = 1.0 - 1e-9;
/// So many planes are looked back at for one that is the same.
const MOST_BACK: usize = 16;
/// How far a corner has to be off the line between its neighbors, as a share of the whole.
const CORNER: f32 = 1e-5;

/// One thing on one plane.
#[derive(Clone, Copy, Debug)]
pub struct Lying {
    /// The normal of the plane, and how far that is from the origin.
    pub normal: DVec3,
    pub offset: f64,
    /// What lies there, by two points of it.
    pub over: [DVec3; 2],
}

impl Lying {
    fn is_same(&self, other: &Self, tolerance: f64) -> bool {
        self.over == other.over
            && self.normal.dot(other.normal) >= ALIKE
            && (self.offset - other.offset).abs() <= tolerance
    }
}

/// A corner of a piece, halfway between two surfaces, and how deep; less than zero above.
#[derive(Clone, Copy, Debug)]
struct Corner {
    group: u32,
    at: Vec2,
    point: PatchPoint,
}

/// All that lies on something, piece by piece.
#[derive(Clone, Debug, Default)]
pub struct Flush {
    /// What lies on one plane, and in how many pieces.
    groups: Vec<(Lying, u32)>,
    corners: Vec<Corner>,
    hull: Vec<u32>,
}

impl Flush {
    pub fn clear(&mut self) {
        self.groups.clear();
        self.corners.clear();
    }

    /// Takes up the corners of a piece, with their depths, seen along an axis.
    pub fn add(
        &mut self,
        lying: Lying,
        tolerance: f64,
        axis: Vec3A,
        piece: impl Iterator<Item = PatchPoint>,
    ) {
        let first = self.groups.len().saturating_sub(MOST_BACK);
        let known = self.groups[first..]
            .iter()
            .rposition(|(known, _)| known.is_same(&lying, tolerance));
        let group = known.map_or_else(
            || {
                self.groups.push((lying, 0));
                self.groups.len() - 1
            },
            |known| first + known,
        );
        self.groups[group].1 += 1;
        let (x, y) = axis.any_orthonormal_pair();
        self.corners.extend(piece.map(|point| Corner {
            group: group as u32,
            at: Vec2::new(point.point.dot(x), point.point.dot(y)),
            point,
        }));
    }

    /// Puts all points that are below a surface, to within a tolerance, into a patch: the corners of
    /// single pieces, and of several on one plane those of all together.
    pub fn gather(&mut self, tolerance: f32, patch: &mut Patch) {
        let Self {
            groups,
            corners,
            hull,
        } = self;
        corners.sort_unstable_by_key(|corner| corner.group);
        let mut rest = corners.as_slice();
        for (group, (_, pieces)) in groups.iter().enumerate() {
            let count = rest.partition_point(|corner| corner.group as usize <= group);
            let (own, others) = rest.split_at(count);
            rest = others;
            hull.clear();
            if *pieces > 1 {
                fill_hull(own, hull);
            } else {
                hull.extend(0..own.len() as u32);
            }
            for corner in hull.iter() {
                let PatchPoint { point, depth } = own[*corner as usize].point;
                if depth >= -tolerance {
                    patch.add_point(point, depth);
                }
            }
        }
    }
}

/// The corners of the convex hull of points, by their indices: from one to the next, with all others
/// to the left (Jarvis, *On the Identification of the Convex Hull of a Finite Set of Points in the
/// Plane*, 1973).
fn fill_hull(points: &[Corner], hull: &mut Vec<u32>) {
    let at = |index: u32| points[index as usize].at;
    let all = 0..points.len() as u32;
    let middle = all.clone().map(at).sum::<Vec2>() / points.len() as f32;
    let from_middle = |index: &u32| at(*index).distance_squared(middle);
    let furthest = all
        .clone()
        .max_by(|a, b| from_middle(a).total_cmp(&from_middle(b)));
    let Some(start) = furthest else {
        return;
    };
    let least = CORNER * at(start).distance(middle);
    let mut last = start;
    while hull.len() < points.len() {
        hull.push(last);
        let mut next: Option<(u32, Vec2)> = None;
        for index in all.clone() {
            let way = at(index) - at(last);
            if way.length() <= least {
                continue;
            }
            let is_next = next.is_none_or(|(_, best)| {
                let off = best.perp_dot(way);
                let on_line = least * best.length().max(way.length());
                off < -on_line || (off <= on_line && way.length() > best.length())
            });
            if is_next {
                next = Some((index, way));
            }
        }
        match next {
            Some((index, _)) if at(index).distance(at(start)) > least => last = index,
            _ => break,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What lies at a height on a plane, in pieces.
    fn gathered(pieces: &[&[[f32; 3]]]) -> Vec<Vec3A> {
        let (mut flush, mut patch) = (Flush::default(), Patch::default());
        for piece in pieces {
            let lying = Lying {
                normal: DVec3::Y,
                offset: 0.0,
                over: [DVec3::ZERO, DVec3::X],
            };
            let corners = piece.iter().map(|corner| {
                let [x, z, depth] = *corner;
                let point = Vec3A::new(x, -0.5 * depth, z);
                PatchPoint { point, depth }
            });
            flush.add(lying, 1e-4, Vec3A::Y, corners);
        }
        flush.gather(1e-4, &mut patch);
        let mut points: Vec<_> = patch.points.iter().map(|point| point.point).collect();
        points.sort_by(|a, b| a.to_array().partial_cmp(&b.to_array()).unwrap());
        points
    }

    #[test]
    fn where_pieces_join_there_is_no_corner() {
        let whole = [
            [0.0, 0.0, 0.1],
            [2.0, 0.0, 0.1],
            [2.0, 1.0, 0.1],
            [0.0, 1.0, 0.1],
        ];
        let [a, b, c, d] = whole;
        let ([low, high], off) = ([[0.7, 1e-9, 0.1], [1.2, 1.0 - 1e-9, 0.1]], [1.0, 0.5, 0.1]);
        let found = gathered(&[&[a, low, high, d], &[low, b, off], &[off, b, c, high]]);
        assert_eq!(found.len(), 4);
        assert_eq!(found, gathered(&[&whole]));
        // All of one line.
        let found = gathered(&[&[a, low], &[low, [1.3, 0.0, 0.1]], &[[1.3, 0.0, 0.1], b]]);
        assert_eq!(found.len(), 2);
        // One of them lower than the others.
        let [high, low] = [-1.0, 0.1];
        let (a, b) = ([0.0, 0.0, low], [2.0, 0.0, high]);
        let found = gathered(&[&[a, [1.0, 0.0, 0.05], d], &[[1.0, 0.0, 0.05], b, d]]);
        assert_eq!(found.len(), 2);
        assert_eq!(gathered(&[&[a], &[a]]).len(), 1);
    }
}
