//! The times of the stages, tick by tick, as columns.

use std::collections::VecDeque;

use bevy::{
    asset::RenderAssetUsages,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use bevy_octree::diagnostics::StageTimes;

use crate::play;

/// The graph, and what is drawn in it.
#[derive(Resource, Clone, Debug)]
pub struct Graph {
    /// What it is drawn to.
    pub image: Handle<Image>,
    /// The milliseconds of each stage, of the last ticks.
    ticks: VecDeque<[f32; 7]>,
}

impl Graph {
    /// The size of the graph, in pixels.
    pub const WIDTH: usize = 268;
    /// See [`WIDTH`](Self::WIDTH).
    pub const HEIGHT: usize = 56;
    /// The stages, in the order in which they run, and the colour of each.
    pub const STAGES: [(&str, [u8; 3]); 7] = [
        ("motion", [150, 156, 168]),
        ("bounds", [86, 180, 233]),
        ("maintenance", [0, 158, 115]),
        ("broad phase", [240, 228, 66]),
        ("narrow phase", [230, 159, 0]),
        ("response", [204, 121, 167]),
        ("report", [213, 94, 0]),
    ];
}

impl FromWorld for Graph {
    fn from_world(world: &mut World) -> Self {
        let size = Extent3d {
            width: Self::WIDTH as u32,
            height: Self::HEIGHT as u32,
            depth_or_array_layers: 1,
        };
        let image = Image::new_fill(
            size,
            TextureDimension::D2,
            &GROUND,
            TextureFormat::Rgba8UnormSrgb,
            RenderAssetUsages::default(),
        );
        Self {
            image: world.resource_mut::<Assets<Image>>().add(image),
            ticks: VecDeque::with_capacity(Self::WIDTH),
        }
    }
}

const GROUND: [u8; 4] = [18, 21, 28, 255];
/// The line at a whole power of two of milliseconds.
const LINE: [u8; 4] = [70, 76, 90, 255];

/// Adds the graph: not in pictures, which are to be the same on every run.
pub fn plugin(app: &mut App) {
    app.init_resource::<Graph>().add_systems(
        Last,
        draw.run_if(play::ticked)
            .run_if(any_with_component::<Window>),
    );
}

fn draw(times: Res<StageTimes>, mut graph: ResMut<Graph>, mut images: ResMut<Assets<Image>>) {
    let mut column = [0.0; 7];
    for (height, (_, time)) in column.iter_mut().zip(times.iter()) {
        *height = time.as_secs_f32() * 1e3;
    }
    if graph.ticks.len() == Graph::WIDTH {
        graph.ticks.pop_front();
    }
    graph.ticks.push_back(column);
    let most = graph.ticks.iter().map(|tick| tick.iter().sum::<f32>());
    let top = most.fold(0.01, f32::max) * 1.1;
    let Some(mut image) = images.get_mut(&graph.image) else {
        return;
    };
    let Some(data) = image.data.as_mut() else {
        return;
    };
    paint(data, &graph.ticks, top);
}

/// Draws columns from the right, stages from the bottom.
fn paint(data: &mut [u8], ticks: &VecDeque<[f32; 7]>, top: f32) {
    let (pixels, _) = data.as_chunks_mut::<4>();
    pixels.fill(GROUND);
    let row = |height: f32| {
        let up = (height / top * Graph::HEIGHT as f32).round() as usize;
        Graph::HEIGHT - up.min(Graph::HEIGHT)
    };
    for (x, tick) in (0..Graph::WIDTH).rev().zip(ticks.iter().rev()) {
        let mut below = 0.0;
        for (height, (_, color)) in tick.iter().zip(Graph::STAGES) {
            let [red, green, blue] = color;
            for y in row(below + height)..row(below) {
                pixels[y * Graph::WIDTH + x] = [red, green, blue, 255];
            }
            below += height;
        }
    }
    // The largest power of two that has room.
    let y = row(top.log2().floor().exp2()).min(Graph::HEIGHT - 1);
    for x in (0..Graph::WIDTH).step_by(4) {
        pixels[y * Graph::WIDTH + x] = LINE;
    }
}
