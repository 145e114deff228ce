//! The octree splits and merges as objects move: Figures 5 to 7 of the 1994 report.
//!
//! `cargo run --release --features scene_files --example split_and_merge`

use std::{
    fs,
    path::{Path, PathBuf},
    process::ExitCode,
};

use arguments::Arguments;
use bevy::{math::bounding::Aabb3d, prelude::*};
use bevy_octree::{
    broad_phase::{ObjectOctree, ObjectOctreeSettings, ProxyId},
    collision_index::CollisionIndex,
    motion::{MotionSettings, Step},
    octree::NodeId,
    prelude::*,
    scene::SceneDescription,
};
use outcome::{Outcome, exit};
use svg::Svg;

#[path = "common/arguments.rs"]
mod arguments;
#[path = "common/outcome.rs"]
mod outcome;
#[path = "common/svg.rs"]
mod svg;

const HELP: &str = "
Three objects and an octree with N = 2. One object crosses the middle of the root: the octree splits twice to keep two
objects to a leaf. It bounces off, crosses back, and the leaves merge.

Prints the octree at the three moments, and writes a picture of each: figure_5.svg, figure_6.svg and figure_7.svg.

Usage: split_and_merge [OPTIONS]

Options:
  --out <FOLDER>     The folder to write to [default: target/split_and_merge]
  --scene <FILE>     The scene to play [default: assets/scenes/figures_5_7.scene.ron]
  --max-objects <N>  How many objects a leaf may list before it splits [default: 2]
  --steps <STEPS>    How many ticks to wait for the split and the merge [default: 60]
  -h, --help         Print help
";

/// What there is to see of a tick.
#[derive(Clone)]
struct Frame {
    tick: u32,
    nodes: usize,
    tree: String,
    root: Aabb3d,
    /// The cubes of the leaves.
    leaves: Vec<Aabb3d>,
    objects: Vec<Object>,
}

#[derive(Clone)]
struct Object {
    name: String,
    aabb: Aabb3d,
    velocity: Vec3,
}

fn main() -> ExitCode {
    exit(run(Arguments::given(HELP)))
}

fn run(mut arguments: Arguments) -> Outcome {
    let out = arguments
        .option("--out")?
        .unwrap_or_else(|| PathBuf::from("target/split_and_merge"));
    let scene = arguments
        .option("--scene")?
        .unwrap_or_else(|| PathBuf::from("assets/scenes/figures_5_7.scene.ron"));
    let max_objects = arguments.option("--max-objects")?.unwrap_or(2);
    let steps = arguments.option("--steps")?.unwrap_or(60);
    let [] = arguments.rest([])?;

    let frames = play(&scene, max_objects, steps)?;
    fs::create_dir_all(&out)
        .map_err(|error| format!("cannot make the folder {}: {error}", out.display()))?;
    let captions = ["before the split", "after the split", "after the merge"];
    for (number, (frame, caption)) in (5..).zip(frames.iter().zip(captions)) {
        let title = format!(
            "Figure {number}: tick {}, {caption}, {} nodes",
            frame.tick, frame.nodes
        );
        println!("{title}\n{}", frame.tree);
        let path = out.join(format!("figure_{number}.svg"));
        picture(frame, &title).save(&path)?;
        println!("{}\n", path.display());
    }
    let [before, split, merged] = frames.map(|frame| frame.nodes);
    println!(
        "scene={} nodes_before={before} nodes_split={split} nodes_merged={merged}",
        scene.display()
    );
    Ok(())
}

/// Runs the scene until the octree has split and merged again; gives the frames before the split,
/// after it, and after the merge.
fn play(scene: &Path, max_objects: u32, steps: u32) -> Outcome<[Frame; 3]> {
    let scene = SceneDescription::load(scene)?;
    let settings = ObjectOctreeSettings::with_max_objects(max_objects);
    settings.check()?;
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
        .insert_resource(BroadPhaseSettings {
            method: BroadPhaseMethod::ObjectOctree(settings),
            ..default()
        })
        .insert_resource(MotionSettings {
            step: Step::Seconds(scene.tick_length()?.as_secs_f32()),
        });
    scene.spawn(&mut app.world_mut().commands())?;
    app.world_mut().flush();

    let mut before: Option<Frame> = None;
    let mut split: Option<[Frame; 2]> = None;
    for tick in 1..=steps {
        app.update();
        let Some(now) = look(&app, tick) else {
            continue;
        };
        match (&before, &split) {
            (Some(before), None) if now.nodes > before.nodes => {
                split = Some([before.clone(), now.clone()]);
            }
            (_, Some([before, after])) if now.nodes < after.nodes => {
                return Ok([before.clone(), after.clone(), now]);
            }
            _ => {}
        }
        before = Some(now);
    }
    Err(format!("the octree did not split and merge within {steps} ticks").into())
}

fn look(app: &App, tick: u32) -> Option<Frame> {
    let world = app.world();
    let index = world.resource::<CollisionIndex>();
    let octree = index.index().engine_as::<ObjectOctree>()?;
    let name = |entity| {
        world
            .get::<Name>(entity)
            .map_or_else(String::new, ToString::to_string)
    };
    let entity = |id: ProxyId| index.entity(id).unwrap_or(Entity::PLACEHOLDER);
    let tree = octree.tree().display_with(NodeId::ROOT, |cell, f| {
        let names: Vec<_> = cell
            .listed()
            .iter()
            .map(|id| name(entity(ProxyId::new(*id))))
            .collect();
        write!(f, "{}", names.join(", "))
    });
    let objects = index.index().proxies().iter().map(|(id, aabb)| Object {
        name: name(entity(id)),
        aabb: *aabb,
        velocity: world
            .get::<Velocity>(entity(id))
            .map_or(Vec3::ZERO, |velocity| velocity.0),
    });
    Some(Frame {
        tick,
        nodes: octree.tree().node_count(),
        tree: tree.to_string(),
        root: octree.root_cell()?,
        leaves: octree
            .tree()
            .leaves(NodeId::ROOT)
            .map(|leaf| octree.tree().data(leaf).cube())
            .collect(),
        objects: objects.collect(),
    })
}

const SIZE: [u32; 2] = [820, 860];
// The borders of the chart.
const LEFT: f32 = 72.0;
const RIGHT: f32 = 803.0;
const TOP: f32 = 45.0;
const BOTTOM: f32 = 799.0;
const LEAF: &str = r##"stroke="#3c5a8c" stroke-width="2" shape-rendering="crispEdges""##;
const OBJECTS: [&str; 3] = ["#0072b2", "#d55e00", "#009e73"];

/// The octree and the objects, seen along z: a square for each cube of a leaf, a filled one for
/// each object, with an arrow as long as the way of ten ticks.
fn picture(frame: &Frame, title: &str) -> Svg {
    let mut svg = Svg::new(SIZE, "#ffffff");
    svg.text(
        [SIZE[0] as f32 / 2.0, 22.0],
        title,
        r#"font-size="19" font-weight="bold" fill="black" text-anchor="middle""#,
    );
    let (low, high) = (frame.root.min, frame.root.max);
    let pixel = |x: f32, y: f32| {
        let (x, y) = (
            (x - low.x) / (high.x - low.x),
            (y - low.y) / (high.y - low.y),
        );
        [LEFT.lerp(RIGHT, x), BOTTOM.lerp(TOP, y)]
    };
    let square = |Aabb3d { min, max }: &Aabb3d| {
        [
            (min.x, min.y),
            (max.x, min.y),
            (max.x, max.y),
            (min.x, max.y),
            (min.x, min.y),
        ]
        .map(|(x, y)| pixel(x, y))
    };
    for leaf in &frame.leaves {
        svg.line(square(leaf), LEAF);
    }
    axes(&mut svg, &frame.root, pixel);
    for (object, color) in frame.objects.iter().zip(OBJECTS.iter().cycle()) {
        let center = (object.aabb.min + object.aabb.max) * 0.5;
        let way = object.velocity * (10.0 / 64.0);
        svg.line(
            square(&object.aabb),
            &format!(r#"fill="{color}" fill-opacity="0.55" stroke="{color}""#),
        );
        if way != Vec3::ZERO {
            let [start, tip] = [
                pixel(center.x, center.y),
                pixel(center.x + way.x, center.y + way.y),
            ];
            let barb = |side: f32| [tip[0] - 14.0 * way.x.signum(), tip[1] + side];
            svg.line(
                [start, tip, barb(-7.0), tip, barb(7.0)],
                r#"stroke="black" stroke-width="2""#,
            );
        }
        let [x, y] = pixel(center.x, object.aabb.max.y);
        svg.text(
            [x, y - 12.0],
            &object.name,
            r#"font-size="15" fill="black" text-anchor="middle""#,
        );
    }
    svg
}

/// Numbers and names along the left and the lower side, a number for each half unit.
fn axes(svg: &mut Svg, root: &Aabb3d, pixel: impl Fn(f32, f32) -> [f32; 2]) {
    let halves = |low: f32, high: f32| {
        ((low * 2.0).ceil() as i32..=(high * 2.0).floor() as i32).map(|number| number as f32 / 2.0)
    };
    let (line, number) = (r#"stroke="black""#, r#"font-size="13" fill="black""#);
    for x in halves(root.min.x, root.max.x) {
        let [at, _] = pixel(x, 0.0);
        svg.line([[at, BOTTOM], [at, BOTTOM + 5.0]], line);
        svg.text(
            [at, BOTTOM + 20.0],
            &format!("{x:.1}"),
            &format!(r#"{number} text-anchor="middle""#),
        );
    }
    for y in halves(root.min.y, root.max.y) {
        let [_, at] = pixel(0.0, y);
        svg.line([[LEFT - 5.0, at], [LEFT, at]], line);
        svg.text(
            [LEFT - 10.0, at + 4.0],
            &format!("{y:.1}"),
            &format!(r#"{number} text-anchor="end""#),
        );
    }
    let middle = [LEFT.midpoint(RIGHT), TOP.midpoint(BOTTOM)];
    svg.text(
        [middle[0], BOTTOM + 42.0],
        "x",
        r#"font-size="15" fill="black" text-anchor="middle""#,
    );
    svg.text(
        [18.0, middle[1] + 4.0],
        "y",
        r#"font-size="15" fill="black" text-anchor="middle""#,
    );
}
