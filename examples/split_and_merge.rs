//! The octree splits and merges as objects move: Figures 5 to 7 of the 1994 report.
//!
//! `cargo run --release --example split_and_merge`

use std::{fs, path::PathBuf, process::ExitCode};

use bevy::{math::bounding::Aabb3d, prelude::*};
use bevy_octree::{
    broad_phase::{ObjectOctree, ProxyId},
    octree::NodeId,
    prelude::*,
    scene::SceneDescription,
};
use clap::Parser;
use outcome::{Outcome, exit};
use plot::{Drawn, bold, draw, text};
use plotters::prelude::{BLACK, ChartBuilder, Color, EmptyElement, PathElement, RGBColor, Rectangle, Text};

#[path = "common/outcome.rs"]
mod outcome;
#[path = "common/plot.rs"]
mod plot;

/// Three objects and an octree with N = 2. One object crosses the middle of the root: the octree splits twice to keep
/// two objects to a leaf. It bounces off, crosses back, and the leaves merge.
///
/// Prints the octree at the three moments, and writes a picture of each: figure_5, figure_6 and figure_7, as SVG and
/// PNG.
#[derive(Parser)]
struct Arguments {
    /// The folder to write to.
    #[arg(long, default_value = "target/split_and_merge")]
    out: PathBuf,
    /// The scene to play.
    #[arg(long, default_value = "assets/scenes/figures_5_7.scene.ron")]
    scene: PathBuf,
    /// N: how many objects a leaf may list before it splits.
    #[arg(long, default_value_t = 2)]
    max_objects: u32,
    /// How many ticks to wait for the split and the merge.
    #[arg(long, default_value_t = 60)]
    steps: u32,
}

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
    exit(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Outcome {
    let frames = play(arguments)?;
    fs::create_dir_all(&arguments.out)
        .map_err(|error| format!("cannot make the folder {}: {error}", arguments.out.display()))?;
    let captions = ["before the split", "after the split", "after the merge"];
    for (number, (frame, caption)) in (5..).zip(frames.iter().zip(captions)) {
        let title = format!("Figure {number}: tick {}, {caption}, {} nodes", frame.tick, frame.nodes);
        println!("{title}\n{}", frame.tree);
        let paths =
            draw(&arguments.out.join(format!("figure_{number}")), (820, 860), |canvas| picture(canvas, frame, &title))?;
        println!("{}\n", paths.map(|path| path.display().to_string()).join(", "));
    }
    let [before, split, merged] = frames.map(|frame| frame.nodes);
    println!("scene={} nodes_before={before} nodes_split={split} nodes_merged={merged}", arguments.scene.display());
    Ok(())
}

/// Runs the scene until the octree has split and merged again; gives the frames before the split, after it, and after
/// the merge.
fn play(arguments: &Arguments) -> Outcome<[Frame; 3]> {
    let scene = SceneDescription::load(&arguments.scene)?;
    let settings = ObjectOctreeSettings::with_max_objects(arguments.max_objects);
    settings.check()?;
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, OctreePlugins::new(Update)))
        .insert_resource(BroadPhaseSettings { method: BroadPhaseMethod::ObjectOctree(settings), ..default() })
        .insert_resource(MotionSettings { step: Step::Seconds(scene.tick_length()?.as_secs_f32()) });
    scene.spawn(&mut app.world_mut().commands())?;
    app.world_mut().flush();

    let mut before: Option<Frame> = None;
    let mut split: Option<[Frame; 2]> = None;
    for tick in 1..=arguments.steps {
        app.update();
        let Some(now) = look(&app, tick) else { continue };
        match (&before, &split) {
            (Some(before), None) if now.nodes > before.nodes => split = Some([before.clone(), now.clone()]),
            (_, Some([before, after])) if now.nodes < after.nodes => {
                return Ok([before.clone(), after.clone(), now]);
            }
            _ => {}
        }
        before = Some(now);
    }
    Err(format!("the octree did not split and merge within {} ticks", arguments.steps).into())
}

fn look(app: &App, tick: u32) -> Option<Frame> {
    let world = app.world();
    let index = world.resource::<CollisionIndex>();
    let octree = index.index().engine_as::<ObjectOctree>()?;
    let name = |entity| world.get::<Name>(entity).map_or_else(String::new, ToString::to_string);
    let entity = |id: ProxyId| index.entity(id).unwrap_or(Entity::PLACEHOLDER);
    let tree = octree.tree().display_with(NodeId::ROOT, |cell, f| {
        let names: Vec<_> = cell.listed().iter().map(|id| name(entity(ProxyId::new(*id)))).collect();
        write!(f, "{}", names.join(", "))
    });
    let objects = index.index().proxies().iter().map(|(id, aabb)| Object {
        name: name(entity(id)),
        aabb: *aabb,
        velocity: world.get::<Velocity>(entity(id)).map_or(Vec3::ZERO, |velocity| velocity.0),
    });
    Some(Frame {
        tick,
        nodes: octree.tree().node_count(),
        tree: tree.to_string(),
        root: octree.root_cell()?,
        leaves: octree.tree().leaves(NodeId::ROOT).map(|leaf| octree.tree().data(leaf).cube()).collect(),
        objects: objects.collect(),
    })
}

const LEAF: RGBColor = RGBColor(60, 90, 140);
const OBJECTS: [RGBColor; 3] = [RGBColor(0, 114, 178), RGBColor(213, 94, 0), RGBColor(0, 158, 115)];

/// The octree and the objects, seen along z: a square for each cube of a leaf, a filled one for each object, with an
/// arrow as long as the way of ten ticks.
fn picture(canvas: &plot::Canvas, frame: &Frame, title: &str) -> Drawn {
    let (low, high) = (frame.root.min, frame.root.max);
    let canvas = canvas.titled(title, bold(24))?;
    let mut chart = ChartBuilder::on(&canvas)
        .margin(16)
        .x_label_area_size(44)
        .y_label_area_size(56)
        .build_cartesian_2d(low.x..high.x, low.y..high.y)?;
    chart
        .configure_mesh()
        .disable_mesh()
        .x_desc("x")
        .y_desc("y")
        .label_style(text(16))
        .axis_desc_style(text(18))
        .draw()?;
    let square = |aabb: &Aabb3d| [(aabb.min.x, aabb.min.y), (aabb.max.x, aabb.max.y)];
    chart.draw_series(frame.leaves.iter().map(|leaf| Rectangle::new(square(leaf), LEAF.stroke_width(2))))?;
    for (object, color) in frame.objects.iter().zip(OBJECTS.iter().cycle()) {
        let center = (object.aabb.min + object.aabb.max) * 0.5;
        let way = object.velocity * (10.0 / 64.0);
        let tip = (center.x + way.x, center.y + way.y);
        let barb = |side: f32| (tip.0 - 0.12 * way.x.signum(), tip.1 + side * 0.06);
        let arrow =
            PathElement::new(vec![(center.x, center.y), tip, barb(1.0), tip, barb(-1.0)], BLACK.stroke_width(2));
        chart.draw_series([Rectangle::new(square(&object.aabb), color.mix(0.55).filled())])?;
        chart.draw_series([Rectangle::new(square(&object.aabb), color.stroke_width(2))])?;
        if way != Vec3::ZERO {
            chart.draw_series([arrow])?;
        }
        let label =
            EmptyElement::at((center.x, object.aabb.max.y)) + Text::new(object.name.clone(), (-20, -24), text(18));
        chart.draw_series([label])?;
    }
    Ok(())
}
