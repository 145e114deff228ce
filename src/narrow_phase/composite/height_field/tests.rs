//! Fields against what they are made of.

use super::*;

fn field(random: &mut fastrand::Rng) -> HeightField {
    let (rows, columns) = (random.usize(2..20), random.usize(2..20));
    let size = Vec2::new(random.f32() + 0.1, random.f32() + 0.1);
    let mut field = HeightField::from_fn(rows, columns, size, |_, _| random.f32() * 4.0).unwrap();
    for _ in 0..random.usize(0..6) {
        let (row, column) = (random.usize(0..rows - 1), random.usize(0..columns - 1));
        field.set_hole(row, column, true).unwrap();
    }
    field
}

fn numbers(field: &HeightField) -> Vec<u32> {
    let mut found = Vec::new();
    field.walk(&mut |_, _| true, &mut |triangle| {
        found.push(triangle.number);
    });
    found.sort_unstable();
    found
}

#[test]
fn bad_numbers_are_refused() {
    let size = Vec2::ONE;
    let of = |rows, columns, count, size| HeightField::new(rows, columns, vec![0.0; count], size);
    assert_eq!(
        of(1, 5, 5, size).unwrap_err(),
        ShapeError::FewHeights {
            rows: 1,
            columns: 5
        }
    );
    let expected = ShapeError::HeightCount {
        rows: 3,
        columns: 5,
        heights: 14,
    };
    assert_eq!(of(3, 5, 14, size).unwrap_err(), expected);
    for size in [
        Vec2::new(0.0, 1.0),
        Vec2::new(1.0, -1.0),
        Vec2::splat(f32::MAX),
    ] {
        assert_eq!(
            of(3, 3, 9, size).unwrap_err(),
            ShapeError::FieldCellSize(size)
        );
    }
    assert!(of(3, 3, 9, Vec2::NAN).is_err());
    assert_eq!(
        of(1 << 17, 1 << 17, 0, size).unwrap_err(),
        ShapeError::TooLarge
    );
    assert_eq!(
        of(usize::MAX, usize::MAX, 0, size).unwrap_err(),
        ShapeError::TooLarge
    );
    let one = |x: f32, z: f32| {
        if x == 0.0 && z == 1.0 {
            f32::INFINITY
        } else {
            0.0
        }
    };
    let error = HeightField::from_fn(3, 3, size, one).unwrap_err();
    let expected = ShapeError::NonFiniteHeight {
        row: 2,
        column: 1,
        height: f32::INFINITY,
    };
    assert_eq!(error, expected);

    let mut field = of(3, 4, 12, size).unwrap();
    let before = field.clone();
    assert!(field.set_height(3, 0, 1.0).is_err() && field.set_height(0, 4, 1.0).is_err());
    assert!(field.set_height(0, 0, f32::NAN).is_err());
    assert!(field.set_hole(2, 0, true).is_err() && field.set_hole(0, 3, true).is_err());
    assert_eq!(field, before);
}

#[test]
fn cells_have_two_triangles_that_face_up() {
    let field = HeightField::from_fn(2, 2, Vec2::new(2.0, 4.0), |x, z| x + z).unwrap();
    let [low, high] = [0, 1].map(|number| field.triangle(number).unwrap());
    let corner = |x: f32, z: f32| Vec3A::new(x, x + z, z);
    assert_eq!(
        low,
        [corner(-1.0, -2.0), corner(-1.0, 2.0), corner(1.0, -2.0)]
    );
    assert_eq!(
        high,
        [corner(-1.0, 2.0), corner(1.0, 2.0), corner(1.0, -2.0)]
    );
    for [a, b, c] in [low, high] {
        assert!((b - a).cross(c - a).y > 0.0);
    }
    assert_eq!(field.triangle(2), None);
}

#[test]
fn walks_find_what_is_in_a_box() {
    let mut random = fastrand::Rng::with_seed(1);
    for _ in 0..300 {
        let field = field(&mut random);
        let (center, half, radius) = field.local_bounds();
        let mut corner = || {
            let mut share = || random.f32() * 2.4 - 1.2;
            center + half * Vec3A::new(share(), share(), share())
        };
        let (a, b) = (corner(), corner());
        let (low, high) = (a.min(b), a.max(b));
        let overlaps = |l: Vec3A, h: Vec3A| l.cmple(high).all() && h.cmpge(low).all();
        let mut found = Vec::new();
        field.walk(&mut |l, h| overlaps(l, h), &mut |triangle| {
            assert_eq!(field.triangle(triangle.number), Some(triangle.corners));
            found.push(triangle.number);
        });
        let mut expected = Vec::new();
        for number in 0..field.triangle_count() as u32 {
            let Some([a, b, c]) = field.triangle(number) else {
                continue;
            };
            for corner in [a, b, c] {
                let off = (corner - center).abs();
                assert!(off.cmple(half).all() && off.length() <= radius * 1.000_001);
            }
            if overlaps(a.min(b).min(c), a.max(b).max(c)) {
                expected.push(number);
            }
        }
        found.sort_unstable();
        assert_eq!(found, expected);
    }
}

#[test]
fn edits_are_as_if_it_had_been_made_so() {
    let mut random = fastrand::Rng::with_seed(2);
    for _ in 0..100 {
        let mut field = field(&mut random);
        let (rows, columns) = (field.rows(), field.columns());
        for _ in 0..20 {
            let (row, column) = (random.usize(0..rows), random.usize(0..columns));
            field
                .set_height(row, column, random.f32() * 8.0 - 4.0)
                .unwrap();
            let (row, column) = (random.usize(0..rows - 1), random.usize(0..columns - 1));
            field.set_hole(row, column, random.u8(0..4) == 0).unwrap();
        }
        let anew = HeightField::new(rows, columns, field.heights().to_vec(), field.cell_size());
        let anew = anew.unwrap().with_holes(field.holes()).unwrap();
        assert_eq!((&anew, &anew.levels), (&field, &field.levels));
        assert_eq!(anew.local_bounds(), field.local_bounds());
        assert_eq!(numbers(&anew), numbers(&field));
    }
}

#[test]
fn heights_are_those_of_the_triangles() {
    let mut random = fastrand::Rng::with_seed(3);
    for _ in 0..200 {
        let field = field(&mut random);
        let number = random.u32(0..field.triangle_count() as u32);
        let (u, v) = (random.f32(), random.f32());
        let (u, v) = if u + v > 1.0 {
            (1.0 - u, 1.0 - v)
        } else {
            (u, v)
        };
        let cell = number as usize / 2;
        let (row, column) = (cell / (field.columns() - 1), cell % (field.columns() - 1));
        let [a, b, c] = field.triangles_of(row, column)[number as usize % 2];
        let point = a + (b - a) * u + (c - a) * v;
        let height = field.height_at(point.x, point.z);
        match field.triangle(number) {
            // Steep ones lean on what x and z are rounded to.
            Some(_) => assert!((height.unwrap_or(point.y) - point.y).abs() < 1e-3),
            None => assert!(u < 1e-4 || v < 1e-4 || u + v > 0.9999 || height.is_none()),
        }
        let (_, half, _) = field.local_bounds();
        assert_eq!(field.height_at(half.x * 1.001, 0.0), None);
        assert_eq!(field.height_at(0.0, -half.z * 1.001), None);
        assert_eq!(field.height_at(f32::NAN, 0.0), None);
        let corner = field.height_at(half.x, half.z);
        let is_hole = field.is_hole(field.rows() - 2, field.columns() - 2);
        assert_eq!(corner.is_none(), is_hole);
        let last = field.heights()[field.heights().len() - 1];
        assert!((corner.unwrap_or(last) - last).abs() < 1e-5);
    }
}

#[test]
fn holes_alone_are_nothing() {
    let all = (0..3).flat_map(|row| (0..2).map(move |column| (row, column)));
    let mut field = HeightField::from_fn(4, 3, Vec2::ONE, |x, _| x).unwrap();
    field = field.with_holes(all).unwrap();
    assert_eq!(numbers(&field), [0; 0]);
    assert_eq!(field.holes().count(), 6);
    let (center, half, _) = field.local_bounds();
    assert_eq!((center, half), (Vec3A::ZERO, Vec3A::new(1.0, 0.0, 1.5)));
    field.set_hole(1, 1, false).unwrap();
    assert_eq!(numbers(&field), [6, 7]);
    for (row, column) in field.holes().collect::<Vec<_>>() {
        field.set_hole(row, column, false).unwrap();
    }
    assert_eq!(
        field,
        HeightField::from_fn(4, 3, Vec2::ONE, |x, _| x).unwrap()
    );
}
