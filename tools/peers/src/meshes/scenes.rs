//! The meshes, each of about as many triangles as asked for, whose sides are about one length unit
//! unless said otherwise.

use std::{collections::HashMap, f32::consts::TAU, fmt, str::FromStr};

use bevy::math::{Quat, Vec2, Vec3};

/// How long the corridor is, in length units, however many triangles it has.
const CORRIDOR: f32 = 10_000.0;
/// How many sides the corridor has, as seen along it.
const SIDES: usize = 10;

/// Vertices and triangles.
#[derive(Debug)]
pub struct Mesh {
    pub vertices: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
}

/// What kind of mesh it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scene {
    /// A square of hills, from height noise.
    Terrain,
    /// A closed surface as a scanner leaves it: a ball with bumps of all sizes, none of its
    /// vertices quite in its place.
    Blob,
    /// A winding tunnel, 10 000 length units long.
    Corridor,
    /// Single triangles everywhere.
    Soup,
}

impl Scene {
    pub const ALL: [Self; 4] = [Self::Terrain, Self::Blob, Self::Corridor, Self::Soup];

    pub const fn name(self) -> &'static str {
        match self {
            Self::Terrain => "terrain",
            Self::Blob => "blob",
            Self::Corridor => "corridor",
            Self::Soup => "soup",
        }
    }

    /// Whether the mesh bounds a solid.
    pub const fn is_closed(self) -> bool {
        matches!(self, Self::Blob)
    }

    /// The mesh.
    pub fn mesh(self, triangles: usize, seed: u64) -> Mesh {
        let noise = Noise(seed);
        match self {
            Self::Terrain => terrain(triangles, &noise),
            Self::Blob => blob(triangles, &noise),
            Self::Corridor => corridor(triangles, &noise),
            Self::Soup => soup(triangles, seed),
        }
    }
}

impl fmt::Display for Scene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Scene {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let all = Self::ALL.map(Self::name);
        Self::ALL
            .into_iter()
            .find(|scene| scene.name() == name)
            .ok_or_else(|| format!("unknown scene: expected one of {}", all.join(", ")))
    }
}

impl Mesh {
    pub fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.triangles[triangle].map(|vertex| self.vertices[vertex as usize])
    }

    /// The box around it.
    pub fn bounds(&self) -> [Vec3; 2] {
        self.vertices.iter().fold(
            [Vec3::INFINITY, Vec3::NEG_INFINITY],
            |[low, high], vertex| [low.min(*vertex), high.max(*vertex)],
        )
    }

    /// Joins the quads of a grid of vertices, each cut in two.
    pub fn of_grid(vertices: Vec<Vec3>, columns: u32, rows: u32, is_ring: bool) -> Self {
        let mut triangles = Vec::new();
        let joined = if is_ring { columns } else { columns - 1 };
        for row in 0..rows - 1 {
            for column in 0..joined {
                let next = (column + 1) % columns;
                let [a, b] = [column, next].map(|column| row * columns + column);
                let [d, c] = [column, next].map(|column| (row + 1) * columns + column);
                triangles.extend([[a, c, b], [a, d, c]]);
            }
        }
        Self {
            vertices,
            triangles,
        }
    }
}

/// A small mesh of 800 triangles: a rock of about so large a radius, open at its two poles.
///
/// Open, as what is wholly inside a solid is asked about by one of the engines alone.
pub fn rock(radius: f32, seed: u64) -> Mesh {
    let noise = Noise(seed);
    let (columns, rows) = (20, 21);
    let mut vertices = Vec::new();
    for row in 0..rows {
        let polar = TAU * 0.5 * (row as f32 + 0.5) / rows as f32;
        for column in 0..columns {
            let around = TAU * column as f32 / columns as f32;
            let outwards = Vec3::new(
                polar.sin() * around.sin(),
                polar.cos(),
                polar.sin() * around.cos(),
            );
            let bumps = 1.0 + 0.2 * noise.octaves(outwards * 2.0, 2);
            vertices.push(outwards * radius * bumps);
        }
    }
    Mesh::of_grid(vertices, columns, rows, true)
}

fn terrain(triangles: usize, noise: &Noise) -> Mesh {
    let side = ((triangles as f32 / 2.0).sqrt().round() as u32).max(1) + 1;
    let mut vertices = Vec::new();
    for row in 0..side {
        for column in 0..side {
            let at = Vec2::new(column as f32, row as f32) - (side - 1) as f32 / 2.0;
            let height = 12.0 * noise.octaves(Vec3::new(at.x, 0.0, at.y) / 48.0, 5);
            vertices.push(Vec3::new(at.x, height, at.y));
        }
    }
    Mesh::of_grid(vertices, side, side, false)
}

/// A cube whose faces are grids, blown up to a ball and displaced.
fn blob(triangles: usize, noise: &Noise) -> Mesh {
    let cells = ((triangles as f32 / 12.0).sqrt().round() as i32).max(1);
    let radius = 0.186 * (triangles as f32).sqrt();
    let mut numbers = HashMap::new();
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    let mut vertex = |corner: [i32; 3]| {
        *numbers.entry(corner).or_insert_with(|| {
            // Equal angles between the lines of a face.
            let on_cube =
                corner.map(|steps| (TAU / 8.0 * (2 * steps - cells) as f32 / cells as f32).tan());
            let outwards = Vec3::from(on_cube).normalize();
            let bumps = 1.0 + 0.25 * noise.octaves(outwards * 2.5, 5);
            let shaken = Vec3::from([0, 1, 2].map(|axis| noise.at(corner, axis) - 0.5));
            vertices.push(outwards * radius * bumps + shaken * 0.2);
            vertices.len() as u32 - 1
        })
    };
    for axis in 0..3 {
        for side in [0, cells] {
            for i in 0..cells {
                for j in 0..cells {
                    let mut corner = |i: i32, j: i32| {
                        let mut corner = [side; 3];
                        (corner[(axis + 1) % 3], corner[(axis + 2) % 3]) = (i, j);
                        vertex(corner)
                    };
                    let quad = [
                        corner(i, j),
                        corner(i + 1, j),
                        corner(i + 1, j + 1),
                        corner(i, j + 1),
                    ];
                    let [a, b, c, d] = quad;
                    triangles.extend(if side == 0 {
                        [[a, c, b], [a, d, c]]
                    } else {
                        [[a, b, c], [a, c, d]]
                    });
                }
            }
        }
    }
    Mesh {
        vertices,
        triangles,
    }
}

fn corridor(triangles: usize, noise: &Noise) -> Mesh {
    let rings = (triangles / (2 * SIDES)).max(1) + 1;
    let mut vertices = Vec::new();
    for ring in 0..rings {
        let along = CORRIDOR * ring as f32 / (rings - 1) as f32;
        let center = Vec3::new(
            along,
            15.0 * (along / 150.0).sin(),
            25.0 * (along / 210.0).cos(),
        );
        for side in 0..SIDES {
            let (sin, cos) = (TAU * side as f32 / SIDES as f32).sin_cos();
            let outwards = Vec3::new(0.0, cos, sin);
            let wall = 4.0 + noise.octaves((center + outwards * 4.0) / 3.0, 2);
            vertices.push(center + outwards * wall);
        }
    }
    Mesh::of_grid(vertices, SIDES as u32, rings as u32, true)
}

fn soup(triangles: usize, seed: u64) -> Mesh {
    let mut random = fastrand::Rng::with_seed(seed);
    let side = 2.0 * (triangles as f32).cbrt();
    let mut vertices = Vec::new();
    for _ in 0..triangles {
        let mut point = || Vec3::from([0; 3].map(|_| random.f32() - 0.5));
        let center = point() * side;
        let turn = Quat::from_scaled_axis(point() * 6.0);
        let stretch = Vec3::new(0.6, 0.6, 0.0) + point() * Vec3::new(0.4, 0.4, 0.0);
        for around in [0.0, 1.0, 2.0] {
            let (sin, cos) = (TAU * around / 3.0).sin_cos();
            vertices.push(center + turn * (stretch * Vec3::new(cos, sin, 0.0)));
        }
    }
    let triangles = (0..triangles as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
    Mesh {
        triangles: triangles.collect(),
        vertices,
    }
}

/// Smooth noise from −1 to 1, of values at the corners of a lattice.
struct Noise(u64);

impl Noise {
    /// A number from 0 to 1 for a corner of the lattice.
    fn at(&self, corner: [i32; 3], channel: u64) -> f32 {
        let mut hash = self.0 ^ channel.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        for part in corner {
            hash = (hash ^ u64::from(part as u32)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            hash ^= hash >> 31;
        }
        (hash >> 40) as f32 / (1u64 << 24) as f32
    }

    fn smooth(&self, point: Vec3) -> f32 {
        let low = point.floor();
        let share = point - low;
        let share = share * share * (3.0 - 2.0 * share);
        let low = low.as_ivec3().to_array();
        let mut sum = 0.0;
        for i in 0..8 {
            let bits = [i & 1, i >> 1 & 1, i >> 2 & 1];
            let weights = [0, 1, 2].map(|axis| {
                if bits[axis] == 1 {
                    share[axis]
                } else {
                    1.0 - share[axis]
                }
            });
            let corner = [0, 1, 2].map(|axis| low[axis] + bits[axis]);
            sum += weights.iter().product::<f32>() * self.at(corner, 0);
        }
        2.0 * sum - 1.0
    }

    /// Each octave twice as fine as the one before, and half as high.
    fn octaves(&self, point: Vec3, octaves: i32) -> f32 {
        (0..octaves)
            .map(|octave| 0.5f32.powi(octave) * self.smooth(point * 2f32.powi(octave)))
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_have_about_as_many_triangles_as_asked_for() {
        for scene in Scene::ALL {
            for triangles in [1000, 10_000] {
                let mesh = scene.mesh(triangles, 1);
                let found = mesh.triangles.len() as f32 / triangles as f32;
                assert!((found - 1.0).abs() < 0.05, "{scene}: {found}");
                let most = mesh.triangles.iter().flatten().max();
                assert!(most.is_some_and(|most| (*most as usize) < mesh.vertices.len()));
            }
        }
        assert_eq!(rock(1.0, 1).triangles.len(), 800);
    }

    #[test]
    fn the_blob_is_closed() {
        let mesh = Scene::Blob.mesh(1000, 1);
        let mut edges = HashMap::new();
        for [a, b, c] in mesh.triangles {
            for edge in [[a, b], [b, c], [c, a]] {
                assert_eq!(edges.insert(edge, ()), None);
            }
        }
        assert!(edges.keys().all(|[a, b]| edges.contains_key(&[*b, *a])));
    }
}
