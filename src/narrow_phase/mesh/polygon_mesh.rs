//! Meshes of planar polygons, checked when they are built.

use std::sync::OnceLock;

use bevy::math::{DVec3, Vec3, Vec3A, bounding::Aabb3d};

use super::{
    edges::Bits,
    junctions::Junction,
    normal::checked_normal,
    polygons::Polygons,
    topology::{Solid, Topology},
};
use crate::{
    broad_phase::StillOctree,
    narrow_phase::{error::ShapeError, length::any_length},
};

mod outwards;
mod pieces;
mod winding;

/// A mesh of so many polygons, or fewer, has no tree: they are looked at as quickly one by one.
const FEW: usize = 32;

/// A surface of planar polygons: what the report's system tests edge by edge against polygon.
///
/// * A polygon is a list of three or more vertex indices, convex or not, in one plane, without
///   holes. One that crosses itself is not refused; its inside is then by the even-odd rule.
/// * Neighbouring polygons are turned to the same orientation, where that can be done: that of most
///   of them. Polygons keep their order; vertices are never moved or merged.
/// * What its closed parts enclose is [inside](Self::has_inside), whatever else is in the mesh: the
///   points around which they wind. A part is closed if along each edge as many polygons run one
///   way as the other, be they two, or four as where two boxes share an edge; a vertex on an edge
///   that does not know it, as an exporter or a brush may leave it, cuts the edge in two. Polygons
///   that are alone along an edge, as a flag on a wall, are no part of it, and copies of a polygon
///   count once. So do the two sides of one, where one of them makes a surface closed: a solid that
///   was exported with two sides is a solid. Else they are a wall, which is met from both sides.
/// * The wall of a cavity must face the other way than the outer wall, or the cavity counts as
///   filled. Which way the outer wall faces does not matter: polygons that bound a solid are turned
///   to face out of it.
/// * A room to be walked in, all of it inside a closed surface, is a
///   [surface only](Self::surface_only).
/// * A tree of the polygons is built with the mesh, where there are many: that takes less than the
///   checks do, and no test has to wait for it, or for others that build it.
/// * Where the surface of a solid crosses itself, its inside is what it winds around all the same, but
///   to ask for it takes longer. Whether it does is found out once, when a mesh in one piece is
///   first asked about a point in its box.
///
/// ```
/// use bevy::math::Vec3;
/// use bevy_octree::narrow_phase::PolygonMesh;
///
/// let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
/// let tetrahedron = PolygonMesh::new(corners, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])?;
/// assert_eq!(tetrahedron.edges().len(), 6);
/// assert!(tetrahedron.is_closed());
/// # Ok::<(), bevy_octree::narrow_phase::ShapeError>(())
/// ```
#[doc(alias("trimesh", "mesh collider", "triangle mesh"))]
#[derive(Clone, Debug)]
pub struct PolygonMesh {
    vertices: Vec<Vec3>,
    polygons: Polygons,
    /// A unit normal per polygon, by the right-hand rule.
    normals: Vec<Vec3>,
    edges: Vec<[u32; 2]>,
    /// The polygon across each side.
    across: Vec<u32>,
    /// Where polygons are; none in a mesh of few.
    tree: Option<StillOctree>,
    /// The first polygon of each connected part of the surface.
    shells: Vec<u32>,
    solid: Solid,
    /// Vertices on sides of polygons that bound solids, by side.
    junctions: Vec<Junction>,
    /// By polygon, its number in what the mesh was made from, if some of that was left out.
    sources: Option<Box<[u32]>>,
    open_edge: Option<[u32; 2]>,
    is_surface_only: bool,
    /// Does the surface keep away from itself? Unknown until that is asked.
    keeps_away: OnceLock<bool>,
    /// Polygons that were turned around to face outwards.
    inverted: Option<Bits>,
    center: Vec3A,
    half_size: Vec3A,
    radius: f32,
}

impl PolygonMesh {
    /// Builds a mesh from vertices and polygons, each a list of vertex indices.
    ///
    /// Linear in the number of corners, but for vertices that very many polygons share, and those
    /// that lie on edges of others, which are sorted and searched for: O(n log n) whatever the
    /// input. A vertex in the middle of more than 64 edges is taken to be on none; and where
    /// boxes of very many polygons overlap, the search for vertices on edges ends with some
    /// surfaces taken for open. Vertices that no polygon names are kept, but are no part of the
    /// surface; they have to be finite all the same.
    ///
    /// # Errors
    /// [`ShapeError::Empty`] without polygons, [`ShapeError::NonFiniteVertex`] for any vertex, one
    /// that no polygon names included, and for a polygon that has fewer than three corners, names a vertex that does not exist or names one twice,
    /// has no area (less than a millionth of its size squared) or is not planar (off by more than a
    /// ten-thousandth of its size).
    pub fn new<P: AsRef<[u32]>>(
        vertices: impl Into<Vec<Vec3>>,
        polygons: impl IntoIterator<Item = P>,
    ) -> Result<Self, ShapeError> {
        Self::build(vertices.into(), polygons, Some, 0.0)
    }

    /// The same; polygons are left out for which `refuse` makes nothing of an error. Vertices have
    /// been moved by `slack` at most.
    pub(in crate::narrow_phase) fn build<P: AsRef<[u32]>>(
        vertices: Vec<Vec3>,
        given: impl IntoIterator<Item = P>,
        refuse: impl Fn(ShapeError) -> Option<ShapeError>,
        slack: f64,
    ) -> Result<Self, ShapeError> {
        if u32::try_from(vertices.len()).is_err() {
            return Err(ShapeError::TooLarge);
        }
        if let Some(vertex) = vertices.iter().position(|vertex| !vertex.is_finite()) {
            let position = vertices[vertex];
            return Err(ShapeError::NonFiniteVertex { vertex, position });
        }
        let given = given.into_iter();
        let mut polygons = Polygons::with_capacity(given.size_hint().0);
        let mut normals = Vec::with_capacity(given.size_hint().0);
        let mut sources: Option<Vec<u32>> = None;
        for (polygon, corners) in given.enumerate() {
            let corners = corners.as_ref();
            match checked_normal(&vertices, polygon, corners) {
                Ok(normal) => {
                    normals.push(normal);
                    polygons.push(corners)?;
                    if let Some(sources) = &mut sources {
                        sources.push(polygon as u32);
                    }
                }
                Err(error) => {
                    if let Some(error) = refuse(error) {
                        return Err(error);
                    }
                    // All before it were taken.
                    sources.get_or_insert_with(|| (0..polygon as u32).collect());
                }
            }
        }
        if polygons.len() == 0 {
            return Err(ShapeError::Empty);
        }
        polygons.shrink_to_fit();
        normals.shrink_to_fit();
        let mut mesh = Self {
            vertices,
            polygons,
            normals,
            edges: Vec::new(),
            across: Vec::new(),
            tree: None,
            shells: Vec::new(),
            solid: Solid::None,
            junctions: Vec::new(),
            sources: sources.map(Vec::into_boxed_slice),
            open_edge: None,
            is_surface_only: false,
            keeps_away: OnceLock::new(),
            inverted: None,
            center: Vec3A::ZERO,
            half_size: Vec3A::ZERO,
            radius: 0.0,
        };
        mesh.measure();
        mesh.connect(slack);
        Ok(mesh)
    }

    /// Returns the same mesh as a surface without an inside: what is within it touches nothing but
    /// its polygons.
    ///
    /// Polygons face the way that most of their surface was given.
    ///
    /// A level that is modelled as one closed surface, as a box turned inside out, is solid
    /// otherwise, and whoever walks in it is in contact all the time.
    ///
    /// ```
    /// use bevy::math::Vec3;
    /// use bevy::transform::components::Transform;
    /// use bevy_octree::narrow_phase::{NarrowPhase, Placed, PolygonMesh, Shape, Workspace};
    ///
    /// let corner = |i: u8| Vec3::from([0, 1, 2].map(|axis| f32::from(i >> axis & 1) * 20.0 - 10.0));
    /// let walls = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    /// let solid = PolygonMesh::new((0..8).map(corner).collect::<Vec<_>>(), walls)?;
    /// let room = solid.clone().surface_only();
    /// assert!(solid.has_inside() && !room.has_inside());
    ///
    /// let meets_player = |mesh: PolygonMesh| {
    ///     let (mesh, player) = (Shape::from(mesh), Shape::sphere(0.5));
    ///     let here = Transform::IDENTITY;
    ///     let (mesh, player) = (Placed::new(&mesh, &here), Placed::new(&player, &here));
    ///     NarrowPhase::default().intersects(mesh, player, &mut Workspace::default())
    /// };
    /// assert!(meets_player(solid) && !meets_player(room));
    /// # Ok::<(), bevy_octree::narrow_phase::ShapeError>(())
    /// ```
    #[doc(alias = "hollow")]
    #[must_use]
    pub fn surface_only(mut self) -> Self {
        if let Some(inverted) = self.inverted.take() {
            for polygon in inverted.iter() {
                self.flip_polygon(polygon as usize);
            }
        }
        self.is_surface_only = true;
        self.solid = Solid::None;
        self.junctions = Vec::new();
        self
    }

    /// Returns the vertices, as given; of a Bevy mesh, those that are left of them once they are
    /// welded, which have other indices.
    #[must_use]
    pub fn vertices(&self) -> &[Vec3] {
        &self.vertices
    }

    /// Returns how many polygons there are; at least one.
    ///
    /// Those that were left out do not count: see [`polygon_number`](Self::polygon_number).
    #[must_use]
    pub fn polygon_count(&self) -> usize {
        self.polygons.len()
    }

    /// Returns the vertex indices of the polygons, in the order given; each polygon
    /// counter-clockwise around its [normal](Self::normals). By index, [not by
    /// number](Self::polygon_index).
    #[must_use]
    pub fn polygons(&self) -> impl ExactSizeIterator<Item = &[u32]> {
        self.polygons.iter()
    }

    /// Returns the unit normals of the polygons. By index, [not by number](Self::polygon_index).
    #[must_use]
    pub fn normals(&self) -> &[Vec3] {
        &self.normals
    }

    /// Returns the index of a polygon, by the number that it had in the input: by which hits
    /// [tell](super::super::Impact::polygon) it. `None` if there is none of that number, or it was
    /// left out.
    ///
    /// The two differ where triangles without an area were left out of a Bevy mesh, as at the poles
    /// of a sphere. All that the mesh is asked about a polygon goes by its index: its
    /// [corners](Self::polygons), its [normal](Self::normals), whether it [bounds a
    /// solid](Self::bounds_solid). O(log n) where some were left out, else O(1).
    ///
    /// ```
    /// use bevy::math::Vec3;
    /// use bevy_octree::{narrow_phase::{PolygonMesh, Shape}, prelude::*};
    ///
    /// /// The corners of the triangle that a ray met, in the space of the mesh.
    /// fn corners(hit: &RayHit, shape: &CollisionShape) -> Option<Vec<Vec3>> {
    ///     let Shape::Mesh(mesh) = &shape.0 else { return None };
    ///     let corners = mesh.polygons().nth(mesh.polygon_index(hit.polygon?)?)?;
    ///     Some(corners.iter().map(|corner| mesh.vertices()[*corner as usize]).collect())
    /// }
    /// ```
    #[must_use]
    pub fn polygon_index(&self, number: u32) -> Option<usize> {
        match &self.sources {
            Some(sources) => sources.binary_search(&number).ok(),
            None => Some(number as usize).filter(|index| *index < self.polygon_count()),
        }
    }

    /// Returns the number that a polygon had in the input, by its index: what hits
    /// [tell](super::super::Impact::polygon), and the other way round as
    /// [`polygon_index`](Self::polygon_index). Of a Bevy mesh, that of the triangle.
    ///
    /// # Panics
    /// If there are not so many polygons.
    #[must_use]
    pub fn polygon_number(&self, index: usize) -> u32 {
        assert!(index < self.polygon_count(), "there is no polygon {index}");
        self.source(index as u32)
    }

    /// Returns each edge once, as the indices of its ends.
    #[must_use]
    pub fn edges(&self) -> &[[u32; 2]] {
        &self.edges
    }

    /// Returns `true` if every polygon is part of a closed surface, so that the mesh has no
    /// border and nothing that stands alone.
    ///
    /// That is a matter of edges: it says the same of a [surface only](Self::surface_only) as of
    /// the mesh that it was made from. Of any other, it says that nothing is mere surface.
    ///
    /// Copies of polygons that do, and walls within a solid whose two sides are polygons with the
    /// same corners, do no harm. Whether the mesh encloses anything at all is told by
    /// [`has_inside`](Self::has_inside).
    #[doc(alias = "watertight")]
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.open_edge.is_none()
    }

    /// Returns `true` if the mesh has an inside: some of its polygons bound a solid, and it is not a
    /// [surface only](Self::surface_only).
    #[doc(alias = "solid")]
    #[must_use]
    pub fn has_inside(&self) -> bool {
        self.solid != Solid::None
    }

    /// Returns `true` if a polygon is part of a closed surface that bounds a solid: it then faces
    /// outwards. What is no such part is met from both sides, as all of a
    /// [surface only](Self::surface_only) is. By index, [not by number](Self::polygon_index).
    ///
    /// # Panics
    /// If there are not so many polygons.
    #[inline]
    #[must_use]
    pub fn bounds_solid(&self, polygon: usize) -> bool {
        assert!(
            polygon < self.polygon_count(),
            "there is no polygon {polygon}"
        );
        self.solid.contains(polygon as u32)
    }

    /// Returns `true` if it was made a [surface only](Self::surface_only).
    #[must_use]
    pub const fn is_surface_only(&self) -> bool {
        self.is_surface_only
    }

    /// Returns an edge that keeps the mesh from being [closed](Self::is_closed), if there is one, as
    /// indices of [vertices](Self::vertices): it belongs to a polygon that is part of no closed
    /// surface.
    #[must_use]
    pub fn open_edge(&self) -> Option<[u32; 2]> {
        self.open_edge
    }

    /// Whether it looks as if it was meant to be closed: few sides are alone, and its polygons face
    /// all ways alike, as those of closed surfaces do.
    #[cfg(feature = "mesh")]
    pub(crate) fn is_nearly_closed(&self) -> bool {
        use super::topology::NO_NEIGHBOR;
        const FEW: f32 = 0.1;
        let alone = self.across.iter().filter(|other| **other == NO_NEIGHBOR);
        if alone.count() as f32 > FEW * self.across.len() as f32 {
            return false;
        }
        let (mut sum, mut total) = (DVec3::ZERO, 0.0);
        for corners in self.polygons() {
            let at = |corner: u32| self.vertices[corner as usize].as_dvec3();
            let origin = at(corners[0]);
            let fan = corners[1..].windows(2);
            let area: DVec3 = fan
                .map(|pair| (at(pair[0]) - origin).cross(at(pair[1]) - origin))
                .sum();
            sum += area;
            total += area.length();
        }
        sum.length() <= f64::from(FEW) * total
    }

    /// Returns how much memory the mesh takes, without what Rapier's shapes make of it.
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        let solid = match &self.solid {
            Solid::Some(polygons) => polygons.memory_bytes(),
            Solid::All | Solid::None => 0,
        };
        size_of::<Self>()
            + (self.vertices.capacity() + self.normals.capacity()) * size_of::<Vec3>()
            + self.polygons.memory_bytes()
            + self.edges.capacity() * size_of::<[u32; 2]>()
            + (self.across.capacity() + self.shells.capacity()) * size_of::<u32>()
            + self.junctions.capacity() * size_of::<Junction>()
            + solid
            + self.sources.as_deref().map_or(0, size_of_val)
            + self.inverted.as_ref().map_or(0, Bits::memory_bytes)
            + self.tree.as_ref().map_or(0, StillOctree::memory_bytes)
    }

    /// The polygons across the sides of a polygon, of which side i is that from corner i to the
    /// next; [`NO_NEIGHBOR`](super::topology::NO_NEIGHBOR) where no other polygon shares the side,
    /// or more than one.
    pub(in crate::narrow_phase) fn across(&self, polygon: usize) -> &[u32] {
        &self.across[self.polygons.sides(polygon)]
    }

    /// The tree of the polygons' boxes, in the mesh's own space, if there are enough of them.
    pub(in crate::narrow_phase) const fn tree(&self) -> Option<&StillOctree> {
        self.tree.as_ref()
    }

    /// The same mesh, to be looked at polygon by polygon.
    #[cfg(test)]
    pub(in crate::narrow_phase) fn without_tree(mut self) -> Self {
        self.tree = None;
        self
    }

    /// The number of a polygon in what the mesh was made from.
    pub(in crate::narrow_phase) fn source(&self, polygon: u32) -> u32 {
        self.sources
            .as_ref()
            .map_or(polygon, |sources| sources[polygon as usize])
    }

    #[inline]
    pub(in crate::narrow_phase) fn polygon(&self, polygon: usize) -> &[u32] {
        self.polygons.get(polygon)
    }

    /// The vertex indices by polygon, if all are triangles.
    #[inline]
    pub(in crate::narrow_phase) fn triangles(&self) -> Option<&[[u32; 3]]> {
        self.polygons.triangles()
    }

    pub(in crate::narrow_phase) fn local_bounds(&self) -> (Vec3A, Vec3A, f32) {
        (self.center, self.half_size, self.radius)
    }

    /// The same polygons elsewhere: vertices and normals are mapped, which has to keep
    /// orientations.
    pub(in crate::narrow_phase) fn turned(
        &self,
        vertex: impl Fn(Vec3) -> Vec3,
        normal: impl Fn(Vec3) -> Vec3,
    ) -> Self {
        let mut turned = Self {
            vertices: self.vertices.iter().copied().map(vertex).collect(),
            normals: self.normals.iter().copied().map(normal).collect(),
            polygons: self.polygons.clone(),
            sources: self.sources.clone(),
            edges: self.edges.clone(),
            across: self.across.clone(),
            // Measured anew.
            tree: None,
            shells: self.shells.clone(),
            solid: self.solid.clone(),
            inverted: self.inverted.clone(),
            // Scaled, it may be another matter.
            keeps_away: OnceLock::new(),
            junctions: self.junctions.clone(),
            ..*self
        };
        turned.measure();
        turned
    }

    /// Turns every polygon around.
    pub(in crate::narrow_phase) fn flip(&mut self) {
        for polygon in 0..self.polygon_count() {
            self.flip_polygon(polygon);
        }
    }

    fn flip_polygon(&mut self, polygon: usize) {
        let sides = self.polygons.sides(polygon);
        self.polygons.flip(polygon);
        // The last side is the one that is still between the same two places.
        let others = sides.start..sides.end - 1;
        self.across[others.clone()].reverse();
        self.normals[polygon] = -self.normals[polygon];
        if !self.junctions.is_empty() {
            let place = |side: usize| {
                self.junctions
                    .partition_point(|junction| (junction.side as usize) < side)
            };
            let [start, last, end] = [sides.start, others.end, sides.end].map(place);
            self.junctions[start..last].reverse();
            self.junctions[last..end].reverse();
            for junction in &mut self.junctions[start..end] {
                junction.at = 1.0 - junction.at;
                if (junction.side as usize) < others.end {
                    junction.side = (others.start + others.end - 1) as u32 - junction.side;
                }
            }
        }
    }

    /// Finds edges and shells, orients neighbours alike, and finds out what bounds solids.
    fn connect(&mut self, slack: f64) {
        let topology = Topology::of(&self.vertices, &self.polygons, self.tree.as_ref(), slack);
        self.edges = topology.edges;
        self.across = topology.across;
        self.shells = topology.shells;
        self.shells.shrink_to_fit();
        self.solid = topology.solid;
        self.junctions = topology.junctions;
        self.junctions.shrink_to_fit();
        self.open_edge = topology.open_edge;
        for polygon in topology.flipped {
            self.flip_polygon(polygon as usize);
        }
        self.turn_outwards(topology.surface, &topology.twins);
        let backs = topology
            .twins
            .iter()
            .filter(|twin| twin.of.is_some() && twin.is_turned);
        for twin in backs {
            // They were turned to the front's side.
            let count = self.polygons.len();
            let inverted = self.inverted.get_or_insert_with(|| Bits::none(count));
            inverted.toggle(twin.polygon);
        }
        // A wall that is not within a solid is a surface.
        if self.open_edge.is_none() {
            let mut walls = topology.twins.iter().filter(|twin| twin.of.is_none());
            let outside = walls.find(|twin| !self.winds_around(self.middle(twin.polygon)));
            self.open_edge = outside.map(|twin| {
                let corners = self.polygon(twin.polygon as usize);
                [corners[0].min(corners[1]), corners[0].max(corners[1])]
            });
        }
    }

    /// A point of a polygon, if it is convex.
    fn middle(&self, polygon: u32) -> DVec3 {
        let corners = self.polygon(polygon as usize);
        let [a, b, c] = [0, 1, 2].map(|i| self.vertices[corners[i] as usize].as_dvec3());
        (a + b + c) / 3.0
    }

    /// Finds the bounding box and, around its centre, the bounding sphere.
    fn measure(&mut self) {
        let corners = || {
            let all = self.polygons.corners().iter();
            all.map(|&vertex| self.vertices[vertex as usize])
        };
        let min = corners().fold(Vec3::INFINITY, Vec3::min);
        let max = corners().fold(Vec3::NEG_INFINITY, Vec3::max);
        // Halving first cannot overflow.
        let center = min * 0.5 + max * 0.5;
        let radius = corners()
            .map(|v| any_length((v - center).into()))
            .fold(0.0, f32::max);
        self.center = center.into();
        // Not (max - min) / 2, so that both ends are inside whatever the rounding.
        self.half_size = (max - center).max(center - min).into();
        self.radius = radius;
        self.tree = (self.polygon_count() > FEW).then(|| match self.triangles() {
            Some(triangles) => {
                let at = |vertex: u32| self.vertices[vertex as usize];
                StillOctree::of_triangles(triangles.iter().map(|triangle| triangle.map(at)))
            }
            None => {
                let polygons = self.polygons();
                let boxes: Vec<_> = polygons.map(|corners| self.bounds_of(corners)).collect();
                StillOctree::new(&boxes)
            }
        });
    }

    fn bounds_of(&self, corners: &[u32]) -> Aabb3d {
        let at = |vertex: &u32| Vec3A::from(self.vertices[*vertex as usize]);
        let first = at(&corners[0]);
        let (min, max) = corners[1..]
            .iter()
            .map(at)
            .fold((first, first), |(min, max), corner| {
                (min.min(corner), max.max(corner))
            });
        Aabb3d { min, max }
    }
}

#[cfg(test)]
pub(in crate::narrow_phase) mod tests;
