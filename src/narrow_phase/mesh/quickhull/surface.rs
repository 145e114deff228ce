//! The surface of a hull that is being built: faces with any number of sides, and who is across.

use bevy::math::DVec3;

/// The surface is none any more: a face would meet itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Broken;

/// A side of a face: from the end of the one before it to its own.
#[derive(Clone, Copy, Debug)]
struct Side {
    /// The point at which it ends.
    end: u32,
    next: u32,
    previous: u32,
    /// The same edge, as a side of the face across it.
    twin: u32,
    face: u32,
}

#[derive(Clone, Copy, Debug)]
struct Face {
    /// One of its sides.
    side: u32,
    normal: DVec3,
    /// The mean of its corners, through which its plane is taken to go.
    middle: DVec3,
    area: f64,
    is_alive: bool,
}

/// A closed surface.
#[derive(Debug)]
pub(super) struct Surface<'a> {
    points: &'a [DVec3],
    sides: Vec<Side>,
    faces: Vec<Face>,
}

/// What a point outside sees, and its border.
#[derive(Debug, Default)]
pub(super) struct Horizon {
    /// The faces that are seen, and are gone.
    pub seen: Vec<u32>,
    /// Their sides at which other faces begin, in order.
    pub sides: Vec<u32>,
}

impl<'a> Surface<'a> {
    /// The surface of a tetrahedron whose last corner is behind the plane of the others, as seen
    /// from where these are counter-clockwise.
    pub fn tetrahedron(points: &'a [DVec3], [a, b, c, d]: [u32; 4]) -> Self {
        let mut surface = Self {
            points,
            sides: Vec::new(),
            faces: Vec::new(),
        };
        let triangles = [[a, b, c], [d, b, a], [d, c, b], [d, a, c]];
        let faces = triangles.map(|corners| surface.add_triangle(corners));
        debug_assert_eq!(faces, [0, 1, 2, 3]);
        for side in 0..12 {
            let ends = surface.ends(side);
            let is_twin = |other: &u32| surface.ends(*other) == [ends[1], ends[0]];
            let twin = (0..12).find(is_twin).expect("each edge has two sides");
            surface.sides[side as usize].twin = twin;
        }
        surface
    }

    /// A face that is joined to nothing yet. Its first side ends at its first corner.
    fn add_triangle(&mut self, corners: [u32; 3]) -> u32 {
        let (face, first) = (self.faces.len() as u32, self.sides.len() as u32);
        for (i, end) in (0..).zip(corners) {
            self.sides.push(Side {
                end,
                next: first + (i + 1) % 3,
                previous: first + (i + 2) % 3,
                twin: u32::MAX,
                face,
            });
        }
        self.faces.push(Face {
            side: first,
            normal: DVec3::ZERO,
            middle: DVec3::ZERO,
            area: 0.0,
            is_alive: true,
        });
        self.measure(face);
        face
    }

    pub fn face_count(&self) -> usize {
        self.faces.len()
    }

    pub fn is_alive(&self, face: u32) -> bool {
        self.faces[face as usize].is_alive
    }

    pub fn area(&self, face: u32) -> f64 {
        self.faces[face as usize].area
    }

    /// How far a point is outside of a face.
    #[inline]
    pub fn height(&self, face: u32, point: u32) -> f64 {
        let face = &self.faces[face as usize];
        face.normal.dot(self.points[point as usize] - face.middle)
    }

    /// How far the middle of a face is outside of another one.
    pub fn reach(&self, of: u32, over: u32) -> f64 {
        let over = &self.faces[over as usize];
        over.normal
            .dot(self.faces[of as usize].middle - over.middle)
    }

    /// The sides of a face, in order.
    pub fn sides(&self, face: u32) -> impl Iterator<Item = u32> {
        let first = self.faces[face as usize].side;
        let next = move |side: &u32| {
            let next = self.sides[*side as usize].next;
            (next != first).then_some(next)
        };
        // None has more sides than there are.
        std::iter::successors(Some(first), next).take(self.sides.len())
    }

    /// The face across a side.
    pub fn across(&self, side: u32) -> u32 {
        let twin = self.sides[side as usize].twin;
        self.sides[twin as usize].face
    }

    /// The faces across the sides of a face, and itself.
    pub fn beside(&self, face: u32) -> Vec<u32> {
        let across = self.sides(face).map(|side| self.across(side));
        across.chain([face]).collect()
    }

    /// Where a side begins and ends.
    fn ends(&self, side: u32) -> [u32; 2] {
        let Side { end, previous, .. } = self.sides[side as usize];
        [self.sides[previous as usize].end, end]
    }

    /// Takes away all faces that a point is outside of, from one that it is outside of on.
    pub fn horizon(&mut self, face: u32, eye: u32, tolerance: f64) -> Horizon {
        let mut horizon = Horizon::default();
        // The next side of each face that was entered, and the one by which it was; this one itself
        // only in the first.
        let first = self.faces[face as usize].side;
        let mut way = vec![(first, first, true)];
        self.faces[face as usize].is_alive = false;
        horizon.seen.push(face);
        while let Some((side, last, is_first)) = way.last_mut() {
            if side == last && !*is_first {
                way.pop();
                continue;
            }
            let at = *side;
            (*side, *is_first) = (self.sides[at as usize].next, false);
            let (twin, other) = (self.sides[at as usize].twin, self.across(at));
            if !self.is_alive(other) {
                continue;
            }
            if self.height(other, eye) > tolerance {
                self.faces[other as usize].is_alive = false;
                horizon.seen.push(other);
                way.push((self.sides[twin as usize].next, twin, false));
            } else {
                horizon.sides.push(at);
            }
        }
        horizon
    }

    /// Closes the surface with triangles from a point to the sides of its horizon; returns these.
    pub fn fan(&mut self, eye: u32, sides: &[u32]) -> Result<Vec<u32>, Broken> {
        let ends: Vec<_> = sides.iter().map(|side| self.ends(*side)).collect();
        let next = ends.iter().cycle().skip(1);
        let is_ring = ends.iter().zip(next).all(|(one, next)| one[1] == next[0]);
        let mut corners: Vec<_> = ends.iter().map(|ends| ends[0]).collect();
        corners.sort_unstable();
        corners.dedup();
        if !is_ring || sides.len() < 3 || corners.len() < sides.len() {
            return Err(Broken);
        }
        let mut faces = Vec::with_capacity(sides.len());
        for (side, ends) in sides.iter().zip(ends) {
            let face = self.add_triangle([eye, ends[0], ends[1]]);
            let base = self.faces[face as usize].side + 2;
            let twin = self.sides[*side as usize].twin;
            self.join(base, twin);
            faces.push(face);
        }
        for (i, face) in faces.iter().enumerate() {
            // From the end of the one before it, which is the beginning of this one.
            let before = faces[(i + faces.len() - 1) % faces.len()];
            let [side, before] = [*face, before].map(|face| self.faces[face as usize].side);
            self.join(side + 1, before);
        }
        Ok(faces)
    }

    fn join(&mut self, side: u32, twin: u32) {
        self.sides[side as usize].twin = twin;
        self.sides[twin as usize].twin = side;
    }

    fn follow(&mut self, side: u32, next: u32) {
        self.sides[side as usize].next = next;
        self.sides[next as usize].previous = side;
    }

    /// Merges the face of a side with the one across it, and returns those that are gone: that, and
    /// triangles that had nothing but two sides left.
    pub fn merge(&mut self, side: u32) -> Result<Vec<u32>, Broken> {
        let (face, other) = (self.sides[side as usize].face, self.across(side));
        if face == other {
            return Err(Broken);
        }
        let Side {
            mut next,
            mut previous,
            twin,
            ..
        } = self.sides[side as usize];
        let Side {
            next: mut twin_next,
            previous: mut twin_previous,
            ..
        } = self.sides[twin as usize];
        // All sides on end that the two have in common.
        while self.across(previous) == other && self.sides[previous as usize].twin == twin_next {
            previous = self.sides[previous as usize].previous;
            twin_next = self.sides[twin_next as usize].next;
            if previous == side {
                return Err(Broken);
            }
        }
        while self.across(next) == other && self.sides[next as usize].twin == twin_previous {
            twin_previous = self.sides[twin_previous as usize].previous;
            next = self.sides[next as usize].next;
            if next == side {
                return Err(Broken);
            }
        }
        self.faces[other as usize].is_alive = false;
        let mut at = twin_next;
        loop {
            self.sides[at as usize].face = face;
            if at == twin_previous {
                break;
            }
            at = self.sides[at as usize].next;
        }
        self.faces[face as usize].side = next;
        self.follow(twin_previous, next);
        self.follow(previous, twin_next);
        let mut gone = vec![other];
        gone.extend(self.straighten(next)?);
        // Not the one that was next, if it is gone by now.
        let after = self.sides[previous as usize].next;
        gone.extend(self.straighten(after)?);
        if self.sides(face).any(|side| self.across(side) == face) {
            return Err(Broken);
        }
        self.measure(face);
        Ok(gone)
    }

    /// If a side and the one before it have the same face across, that and this one have no corner
    /// where they meet any more: the two are made one. Returns the face across if nothing is left of
    /// it.
    fn straighten(&mut self, side: u32) -> Result<Option<u32>, Broken> {
        let Side {
            previous,
            twin,
            face,
            ..
        } = self.sides[side as usize];
        let other = self.across(side);
        if other != self.across(previous) {
            return Ok(None);
        }
        if other == face || self.sides[twin as usize].next != self.sides[previous as usize].twin {
            return Err(Broken);
        }
        let beyond = self.sides[previous as usize].twin;
        self.faces[face as usize].side = side;
        let before = self.sides[previous as usize].previous;
        self.follow(before, side);
        let count = self.sides(other).count();
        let mut gone = None;
        if count == 3 {
            // The third side of the triangle is now a side of this face.
            let third = self.sides[beyond as usize].next;
            let outer = self.sides[third as usize].twin;
            self.faces[other as usize].is_alive = false;
            self.join(side, outer);
            gone = Some(other);
        } else if count > 3 {
            self.faces[other as usize].side = twin;
            let after = self.sides[beyond as usize].next;
            self.sides[twin as usize].end = self.sides[beyond as usize].end;
            self.follow(twin, after);
            self.measure(other);
        } else {
            return Err(Broken);
        }
        if self.sides(face).count() < 3 {
            return Err(Broken);
        }
        Ok(gone)
    }

    /// Finds the plane of a face, by Newell's sums.
    fn measure(&mut self, face: u32) {
        let (mut sum, mut count) = (DVec3::ZERO, 0.0);
        let at = |side: u32| self.points[self.sides[side as usize].end as usize];
        for side in self.sides(face) {
            sum += at(side);
            count += 1.0;
        }
        let middle = sum / count;
        let mut area = DVec3::ZERO;
        for side in self.sides(face) {
            let [from, to] = self.ends(side).map(|point| self.points[point as usize]);
            area += (from - middle).cross(to - middle);
        }
        let face = &mut self.faces[face as usize];
        face.middle = middle;
        face.area = area.length();
        face.normal = area.normalize_or_zero();
    }

    /// The corners of all faces; `None` if there are too few for a solid.
    pub fn polygons(&self) -> Option<Vec<Vec<u32>>> {
        let alive = (0..self.faces.len() as u32).filter(|face| self.is_alive(*face));
        let corners = |face: u32| self.sides(face).map(|side| self.sides[side as usize].end);
        let polygons: Vec<Vec<u32>> = alive.map(|face| corners(face).collect()).collect();
        (polygons.len() > 3).then_some(polygons)
    }
}
