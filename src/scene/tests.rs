//! Scene texts, good and bad.

use std::{borrow::Cow, path::Path};

use bevy::math::Vec3;

use super::*;
use crate::{
    motion::{Interpolation, Outside, PositionTrack},
    narrow_phase::Shape,
};

/// A scene text with one object, whose fields follow the shape.
fn object(fields: &str) -> String {
    format!("(name: \"x\", content: Objects([\n  (shape: Sphere(radius: 1), {fields}),\n]))")
}

#[test]
fn every_field_is_read() {
    let scene = SceneDescription::parse(
        r#"(
            name: "all",
            ticks_per_second: 30,
            content: Objects([
                (shape: Cuboid(half_size: (1, 2, 3))),
                (
                    name: "mover",
                    shape: Sphere(radius: 0.5),
                    position: (1, 0, -1),
                    rotation: (0, 90, 0),
                    scale: (2, 2, 2),
                    motion: Velocity(0, 1.5, 0),
                ),
                (
                    shape: Cuboid(half_size: (1, 1, 1)),
                    motion: Track(
                        keyframes: [(0, (0, 0, 0)), (60, (1, 0, 0))],
                        interpolation: Smooth,
                        outside: Loop,
                    ),
                ),
            ]),
        )"#,
    )
    .unwrap();
    let half_size = Vec3::new(1.0, 2.0, 3.0);
    let track = PositionTrack::new([(0, Vec3::ZERO), (60, Vec3::X)])
        .unwrap()
        .with_interpolation(Interpolation::Smooth)
        .with_outside(Outside::Loop);
    let expected = SceneDescription {
        ticks_per_second: 30.0,
        ..SceneDescription::new(
            "all",
            [
                ObjectDescription::new(ShapeDescription::Cuboid { half_size }),
                ObjectDescription {
                    name: Some("mover".into()),
                    shape: ShapeDescription::Sphere { radius: 0.5 },
                    position: Vec3::new(1.0, 0.0, -1.0),
                    rotation: Vec3::Y * 90.0,
                    scale: Vec3::splat(2.0),
                    motion: Motion::Velocity(Vec3::Y * 1.5),
                },
                ObjectDescription {
                    motion: Motion::Track(track),
                    ..ObjectDescription::new(ShapeDescription::Cuboid {
                        half_size: Vec3::ONE,
                    })
                },
            ],
        )
    };
    assert_eq!(scene, expected);
    assert_eq!(scene.object_count(), 3);
    let forward = scene.objects().nth(1).unwrap().transform().forward();
    assert!(forward.abs_diff_eq(Vec3::NEG_X, 1e-6));
}

#[test]
fn a_track_may_say_when_it_starts() {
    use crate::motion::TrackStart;

    let track = "keyframes: [(0, (0, 0, 0))]";
    for (start, expected) in [
        ("", TrackStart::At(0)),
        ("start: At(120)", TrackStart::At(120)),
        ("start: Now", TrackStart::Now),
    ] {
        let text = object(&format!("motion: Track({track}, {start})"));
        let scene = SceneDescription::parse(&text).unwrap();
        let Motion::Track(track) = scene.objects().next().unwrap().motion.clone() else {
            panic!("{text}")
        };
        assert_eq!(track.start(), expected);
    }
}

#[test]
fn what_is_written_reads_back() {
    let mesh = ShapeDescription::Mesh {
        vertices: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z],
        polygons: vec![vec![0, 2, 1], vec![0, 1, 3], vec![0, 3, 2], vec![1, 2, 3]],
        surface_only: true,
    };
    let Ok(Shape::Mesh(room)) = mesh.build() else {
        panic!("it is a mesh")
    };
    assert!(room.is_closed() && !room.has_inside());
    let track = PositionTrack::new([(3, Vec3::ONE)]).unwrap();
    let [later, now] = [track.clone().starting_at(7), track.clone().starting_now()];
    let scene = SceneDescription::new(
        "text with \"quotes\"\n",
        [
            ObjectDescription {
                name: Some("a".into()),
                motion: Motion::Track(track),
                ..ObjectDescription::new(mesh)
            },
            ObjectDescription {
                motion: Motion::Track(later),
                ..ObjectDescription::new(ShapeDescription::Sphere { radius: 1.0 })
            },
            ObjectDescription {
                motion: Motion::Track(now),
                ..ObjectDescription::new(ShapeDescription::Sphere { radius: 1.0 })
            },
            ObjectDescription {
                position: Vec3::new(0.1, 1e-30, -1e30),
                motion: Motion::Velocity(Vec3::X),
                ..ObjectDescription::new(ShapeDescription::Sphere { radius: 0.1 })
            },
        ],
    );
    for scene in [scene, TestSet::new(7).into()] {
        let text = scene.to_ron().unwrap();
        assert_eq!(SceneDescription::parse(&text).unwrap(), scene, "{text}");
    }
}

#[test]
fn bad_texts_name_the_place_and_what_was_expected() {
    let bad = [
        (String::new(), "scene text:1:1: ", "Expected"),
        ("(name: \"x\"".into(), "scene text:1:9: ", "Expected comma"),
        (
            "(name: \"x\")".into(),
            "scene text:1:11: ",
            "missing field named `content`",
        ),
        ("(name: 5)".into(), "scene text:1:8: ", "Expected string"),
        (
            "(name: \"x\",\n content: Cubes(3))".into(),
            "scene text:2:11: ",
            "expected either `TestSet` or `Objects`",
        ),
        (
            "(name: \"x\",\n content: TestSet(rings: -1))".into(),
            "scene text:2:27: ",
            "out of bounds",
        ),
        (
            "(name: \"x\",\n content: // 3 objects\n  7)".into(),
            "scene text:3:3: ",
            "identifier \"7\"",
        ),
        (object("mass: 3"), "scene text:2:30: ", "field named `mass`"),
        (object("position: (1, 2)"), "scene text:2:", "Expected"),
        (
            object("position: (1, NaN, 2)"),
            "scene text:2:",
            "position is [1, NaN, 2], expected finite",
        ),
        (
            object("scale: (1, 0, 1)"),
            "scene text:2:",
            "expected no component to be 0",
        ),
        (
            object("motion: Velocity(inf, 0, 0)"),
            "scene text:2:",
            "velocity is [inf, 0, 0], expected finite",
        ),
        (
            object("motion: Fall"),
            "scene text:2:",
            "expected one of `Static`, `Velocity`, or `Track`",
        ),
        (
            object("motion: Track(keyframes: [])"),
            "scene text:2:",
            "no keyframes, expected at least one",
        ),
        (
            object("motion: Track(keyframes: [(0, (0, 0, 0)),\n (0, (1, 0, 0))])"),
            "scene text:3:",
            "keyframe 1 is at tick 0, expected a tick after 0",
        ),
        (
            object("position: (1, 0, 0), motion: Track(keyframes: [(0, (0, 0, 0))])"),
            "scene text:2:",
            "position is [1, 0, 0], expected none beside a track",
        ),
    ];
    for (text, place, expected) in bad {
        let error = SceneDescription::parse(&text).unwrap_err();
        assert!(matches!(error, SceneError::Parse { .. }), "{error:?}");
        let message = error.to_string();
        assert!(
            message.starts_with(place) && message.contains(expected),
            "{text}\n{message}"
        );
    }
}

#[test]
fn a_newtype_that_is_spelled_twice_is_told_how_to_be_spelled() {
    let test_set = |content: &str| format!("(name: \"x\", content: {content})");
    let track = "keyframes: [(0, (0, 0, 0))]";
    for (text, variant) in [
        (object("motion: Velocity((1, 0, 0))"), "Velocity"),
        (object("motion: Velocity( (1, 0, 0) )"), "Velocity"),
        (object(&format!("motion: Track(({track}))")), "Track"),
        (
            object(&format!("motion: Track(PositionTrack({track}))")),
            "Track",
        ),
        (test_set("TestSet((rings: 3))"), "TestSet"),
        (test_set("TestSet(TestSet(rings: 3))"), "TestSet"),
    ] {
        let message = SceneDescription::parse(&text).unwrap_err().to_string();
        let hint = format!("what is in `{variant}(…)` takes no name and no brackets of its own");
        assert!(message.ends_with(&hint), "{text}\n{message}");
    }
    for text in [
        object("motion: Velocity(x, 0, 0)"),
        test_set("TestSet(ring: 3)"),
        object("position: ((1, 0, 0))"),
    ] {
        let message = SceneDescription::parse(&text).unwrap_err().to_string();
        assert!(
            !message.contains("brackets of its own"),
            "{text}\n{message}"
        );
    }
}

#[test]
fn a_byte_order_mark_is_passed_over() {
    let text = SceneDescription::from(TestSet::new(2)).to_ron().unwrap();
    assert_eq!(
        SceneDescription::parse(&format!("\u{feff}{text}")).unwrap(),
        TestSet::new(2).into()
    );
    let error = SceneDescription::parse("\u{feff}(name: 5)").unwrap_err();
    assert!(
        error
            .to_string()
            .starts_with("scene text:1:8: Expected string"),
        "{error}"
    );
}

#[test]
fn bad_shapes_name_the_place_and_what_was_expected() {
    let bad = [
        (
            "Cuboid(half_size: (1, -1, 1))",
            "must be finite and not negative, got [1, -1, 1]",
        ),
        (
            "Sphere(radius: -1)",
            "must be finite and not negative, got -1",
        ),
        (
            "Sphere(radius: NaN)",
            "must be finite and not negative, got NaN",
        ),
        ("Sphere(diameter: 1)", "field named `diameter`"),
        (
            "Capsule(radius: 1)",
            "missing field named `length` in `Capsule`",
        ),
        (
            "Mesh(vertices: [(0, 0, 0)], polygons: [])",
            "needs at least one polygon",
        ),
        (
            "Convex(vertices: [(0, inf, 0)], polygons: [[0, 0, 0]])",
            "vertex 0 is not finite: [0, inf, 0]",
        ),
        (
            "Mesh(vertices: [(0, 0, 0)], polygons: [[0, 0]])",
            "polygon 0 has 2 corners, but needs at least 3",
        ),
        (
            "Mesh(vertices: [(0, 0, 0)], polygons: [[0, 0, 1]])",
            "polygon 0 names vertex 1, but there are only 1",
        ),
    ];
    for (shape, expected) in bad {
        let text =
            format!("(name: \"x\", content: Objects([\n  (name: \"box\", shape: {shape}),\n]))");
        let message = SceneDescription::parse(&text).unwrap_err().to_string();
        assert!(
            message.starts_with("scene text:2:") && message.contains(expected),
            "{message}"
        );
    }
}

#[test]
fn invalid_scenes_say_why() {
    let bad = [
        (
            "(name: \"x\", content: Objects([]))",
            "scene text: the scene has no objects, expected at least one",
        ),
        (
            "(name: \"x\", ticks_per_second: 0, content: TestSet(rings: 1))",
            "scene text: ticks_per_second is 0, expected a positive number",
        ),
        (
            "(name: \"x\", ticks_per_second: -64, content: TestSet(rings: 1))",
            "scene text: ticks_per_second is -64, expected a positive number",
        ),
        (
            "(name: \"x\", ticks_per_second: inf, content: TestSet(rings: 1))",
            "scene text: ticks_per_second is inf, expected a positive number",
        ),
        (
            "(name: \"x\", content: TestSet(rings: 1, side: 2))",
            "scene text: test set: spacing is 1.5, expected more than side",
        ),
        (
            "(name: \"x\", content: Objects([(name: \"object_1\", shape: Sphere(radius: 1)), (shape: Sphere(radius: 1))]))",
            "scene text: objects 0 and 1 are both named \"object_1\", expected unique names",
        ),
    ];
    for (text, expected) in bad {
        let error = SceneDescription::parse(text).unwrap_err();
        assert!(matches!(error, SceneError::Invalid { .. }), "{error:?}");
        assert_eq!(error.to_string(), expected);
    }
}

#[test]
fn scenes_built_in_code_name_the_object() {
    let ball = ObjectDescription::new(ShapeDescription::Sphere { radius: 1.0 });
    let bad = ObjectDescription {
        rotation: Vec3::NAN,
        ..ball.clone()
    };
    let problem = SceneDescription::new("x", [ball, bad])
        .validate()
        .unwrap_err();
    let expected = "object 1 (\"object_1\"): rotation is [NaN, NaN, NaN], expected finite numbers";
    assert_eq!(problem.to_string(), expected);
}

#[test]
fn files_are_named_in_errors() {
    let folder = std::env::temp_dir().join(format!("bevy_octree_scene_{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("bad.scene.ron");

    let error = SceneDescription::load(&file).unwrap_err();
    assert!(matches!(&error, SceneError::Read { path, .. } if *path == file));
    assert!(
        error
            .to_string()
            .starts_with(&format!("{}: cannot read", file.display()))
    );

    std::fs::write(&file, "(\n  name: \"x\",\n  contents: [],\n)").unwrap();
    let message = SceneDescription::load(&file).unwrap_err().to_string();
    assert!(
        message.starts_with(&format!("{}:3:3: ", file.display())),
        "{message}"
    );
    assert!(
        message.contains("`contents`") && message.contains("`content`"),
        "{message}"
    );

    std::fs::write(&file, b"(name: \"\xff\")").unwrap();
    assert!(matches!(
        SceneDescription::load(&file),
        Err(SceneError::Read { .. })
    ));

    let scene = SceneDescription::from(TestSet::new(2));
    scene.save(&file).unwrap();
    assert_eq!(SceneDescription::load(&file).unwrap(), scene);
    let error = scene.save(Path::new(&folder)).unwrap_err();
    assert!(matches!(error, SceneError::Write { .. }));
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn test_sets_write_out_their_cubes() {
    let scene = SceneDescription::from(TestSet::new(1));
    assert_eq!((scene.name.as_str(), scene.object_count()), ("t1", 18));
    let objects: Vec<_> = scene.objects().collect();
    assert_eq!(objects.len(), 18);
    assert_eq!(objects[0].name.as_deref(), Some("left_0"));
    assert_eq!(objects[17].name.as_deref(), Some("right_8"));
    assert_eq!(objects[0].motion, Motion::Velocity(Vec3::X * 4.0));
    assert_eq!(objects[9].position, Vec3::X * 1.53125);
    let written_out = SceneDescription::new("t1", objects.into_iter().map(Cow::into_owned));
    assert_eq!(written_out.validate(), Ok(()));
}

/// A file of `assets/scenes`.
fn asset(name: &str) -> SceneDescription {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/scenes");
    SceneDescription::load(folder.join(format!("{name}.scene.ron"))).unwrap()
}

#[test]
fn every_asset_loads_under_its_name() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/scenes");
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let file = entry.unwrap().file_name().into_string().unwrap();
        if let Some(name) = file.strip_suffix(".scene.ron") {
            assert_eq!(asset(name).name, name);
            names.push(name.to_owned());
        }
    }
    names.sort();
    let expected = [
        "clip",
        "figures_5_7",
        "mixed_shapes",
        "t0",
        "t1",
        "t10",
        "t3",
    ];
    assert_eq!(names, expected);
}

#[test]
fn test_set_assets_are_the_defaults() {
    for rings in [0, 1, 3, 10] {
        assert_eq!(asset(&format!("t{rings}")), TestSet::new(rings).into());
    }
}

/// The half extents of an object's box, if it is not turned.
fn half_extents(object: &ObjectDescription) -> Vec3 {
    match object.shape {
        ShapeDescription::Cuboid { half_size } => half_size,
        ShapeDescription::Sphere { radius } => Vec3::splat(radius),
        _ => panic!("{:?} has no simple box", object.shape),
    }
}

/// How many nodes an N-objects octree with N = 2 has, by the definition.
fn node_count(min: Vec3, size: f32, boxes: &[(Vec3, Vec3)]) -> usize {
    let inside: Vec<_> = boxes
        .iter()
        .filter(|(low, high)| high.cmpge(min).all() && low.cmplt(min + size).all())
        .copied()
        .collect();
    if inside.len() <= 2 {
        return 1;
    }
    let octants = (0..8).map(|octant| {
        let corner = Vec3::new(
            (octant & 1) as f32,
            (octant >> 1 & 1) as f32,
            (octant >> 2) as f32,
        );
        node_count(min + corner * size * 0.5, size * 0.5, &inside)
    });
    1 + octants.sum::<usize>()
}

#[test]
fn figures_5_7_split_and_merge() {
    let scene = asset("figures_5_7");
    let objects: Vec<_> = scene.objects().map(Cow::into_owned).collect();
    let mut expected = [(0, 9), (19, 9), (20, 73), (26, 73), (32, 73), (33, 9)]
        .into_iter()
        .peekable();
    let mut positions: Vec<_> = objects.iter().map(|object| object.position).collect();
    let mut direction = 1.0;
    for tick in 0..=33 {
        let boxes: Vec<_> = objects
            .iter()
            .zip(&positions)
            .map(|(object, &center)| (center - half_extents(object), center + half_extents(object)))
            .collect();
        if expected.peek().is_some_and(|&(next, _)| next == tick) {
            let (_, nodes) = expected.next().unwrap();
            assert_eq!(
                node_count(Vec3::splat(-3.0), 6.0, &boxes),
                nodes,
                "tick {tick}"
            );
        }
        let [left, centre, right] = boxes[..] else {
            panic!("three objects");
        };
        let hits = (left.1.x >= centre.0.x, right.0.x <= centre.1.x);
        assert_eq!(hits, (tick == 26, tick == 26), "tick {tick}");
        if tick == 26 {
            direction = -1.0;
        }
        for (object, position) in objects.iter().zip(&mut positions) {
            let Motion::Velocity(velocity) = object.motion else {
                panic!("all three have a velocity");
            };
            *position += direction * velocity / 64.0;
        }
    }
}

/// The intervals of ticks within which the boxes of two objects overlap.
fn overlaps(scene: &SceneDescription, a: &str, b: &str, end: u64) -> Vec<(u64, u64)> {
    let find = |name: &str| {
        let object = scene
            .objects()
            .find(|object| object.name.as_deref() == Some(name));
        object.unwrap().into_owned()
    };
    let (a, b) = (find(a), find(b));
    let at = |object: &ObjectDescription, tick| match &object.motion {
        Motion::Track(track) => track.position(tick),
        _ => object.position,
    };
    let mut intervals: Vec<(u64, u64)> = Vec::new();
    for tick in 0..=end {
        let distance = (at(&a, tick) - at(&b, tick)).abs();
        if distance.cmple(half_extents(&a) + half_extents(&b)).all() {
            match intervals.last_mut() {
                Some((_, last)) if *last + 1 == tick => *last = tick,
                _ => intervals.push((tick, tick)),
            }
        }
    }
    intervals
}

#[test]
fn clip_touches_as_it_says() {
    let scene = asset("clip");
    let times = |a, b| overlaps(&scene, a, b, 240);
    assert_eq!(times("arm", "floor"), [(30, 32)]);
    assert_eq!(times("arm", "satellite").len(), 1);
    assert_eq!(times("satellite", "bay_wall").len(), 2);
    for untouched in ["camera", "hatch"] {
        for other in ["floor", "bay_wall", "satellite", "arm"] {
            assert_eq!(times(untouched, other), [], "{untouched} and {other}");
        }
    }
    for (a, b) in [
        ("arm", "bay_wall"),
        ("satellite", "floor"),
        ("floor", "bay_wall"),
    ] {
        assert_eq!(times(a, b), [], "{a} and {b}");
    }
}

#[test]
fn mixed_shapes_has_one_of_each() {
    let shapes: Vec<_> = asset("mixed_shapes")
        .objects()
        .map(|object| object.shape.build().unwrap())
        .collect();
    assert!(matches!(
        shapes[..],
        [
            Shape::Mesh(_),
            Shape::Convex(_),
            Shape::Sphere { .. },
            Shape::Cuboid { .. }
        ]
    ));
}

#[test]
fn the_examples_of_the_format_are_scenes() {
    let readme = include_str!("../../assets/scenes/README.md");
    let examples: Vec<_> = readme
        .split("```ron\n")
        .skip(1)
        .map(|rest| SceneDescription::parse(rest.split("```").next().unwrap()).unwrap())
        .collect();
    assert_eq!(examples.len(), 2);
    assert_eq!(examples[0].object_count(), 3);
    assert_eq!(examples[1], TestSet::new(3).into());
}
