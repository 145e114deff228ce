//! Writes glTF files: JSON, with the buffers in it.

use base64::{Engine, prelude::BASE64_STANDARD};
use bevy::prelude::*;
use serde_json::{Value, json};

/// `mode` of glTF's primitives.
pub const LINES: u32 = 1;
pub const TRIANGLES: u32 = 4;
pub const STRIP: u32 = 5;

/// What a mesh of one material is made of.
#[derive(Clone)]
pub struct Primitive {
    pub positions: Vec<Vec3>,
    pub indices: Option<Vec<u16>>,
    pub mode: u32,
    pub material: Option<usize>,
    /// Without normals, Bevy computes some, and trusts the indices.
    pub has_normals: bool,
}

impl Primitive {
    /// The triangles of one of Bevy's.
    pub fn of(mesh: impl Into<Mesh>) -> Self {
        let mesh: Mesh = mesh.into();
        let positions = mesh.attribute(Mesh::ATTRIBUTE_POSITION).unwrap();
        let indices = mesh.indices().unwrap();
        Self {
            positions: positions
                .as_float3()
                .unwrap()
                .iter()
                .map(|at| (*at).into())
                .collect(),
            indices: Some(indices.iter().map(|index| index as u16).collect()),
            mode: TRIANGLES,
            material: None,
            has_normals: false,
        }
    }

    pub fn with_material(self, material: usize) -> Self {
        let material = Some(material);
        Self { material, ..self }
    }
}

/// A file, of whatever was added.
#[derive(Default)]
pub struct File {
    buffer: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    meshes: Vec<Value>,
    materials: Vec<Value>,
    nodes: Vec<Value>,
}

impl File {
    pub fn material(&mut self, name: &str) -> usize {
        push(&mut self.materials, json!({ "name": name }))
    }

    pub fn mesh(&mut self, name: &str, primitives: &[Primitive]) -> usize {
        let primitives: Vec<Value> = primitives.iter().map(|part| self.primitive(part)).collect();
        push(
            &mut self.meshes,
            json!({ "name": name, "primitives": primitives }),
        )
    }

    /// A mesh that says it has triangles, and has nothing.
    pub fn mesh_of_nothing(&mut self, name: &str) -> usize {
        let primitives = json!([{ "attributes": {}, "mode": TRIANGLES }]);
        push(
            &mut self.meshes,
            json!({ "name": name, "primitives": primitives }),
        )
    }

    fn primitive(&mut self, part: &Primitive) -> Value {
        let low = part.positions.iter().copied().reduce(Vec3::min).unwrap();
        let high = part.positions.iter().copied().reduce(Vec3::max).unwrap();
        let bytes = part
            .positions
            .iter()
            .flat_map(Vec3::to_array)
            .flat_map(f32::to_le_bytes);
        let view = self.view(bytes.collect());
        let positions = push(
            &mut self.accessors,
            json!({
                "bufferView": view, "componentType": 5126, "type": "VEC3",
                "count": part.positions.len(), "min": low.to_array(), "max": high.to_array(),
            }),
        );
        let mut primitive = json!({ "attributes": { "POSITION": positions }, "mode": part.mode });
        if part.has_normals {
            let bytes = vec![Vec3::Y.to_array(); part.positions.len()];
            let view = self.view(
                bytes
                    .as_flattened()
                    .iter()
                    .flat_map(|at| at.to_le_bytes())
                    .collect(),
            );
            let accessor = json!({
                "bufferView": view, "componentType": 5126, "type": "VEC3", "count": bytes.len(),
            });
            primitive["attributes"]["NORMAL"] = push(&mut self.accessors, accessor).into();
        }
        if let Some(indices) = &part.indices {
            let view = self.view(
                indices
                    .iter()
                    .flat_map(|index| index.to_le_bytes())
                    .collect(),
            );
            let accessor = json!({
                "bufferView": view, "componentType": 5123, "type": "SCALAR", "count": indices.len(),
            });
            primitive["indices"] = push(&mut self.accessors, accessor).into();
        }
        if let Some(material) = part.material {
            primitive["material"] = material.into();
        }
        primitive
    }

    fn view(&mut self, bytes: Vec<u8>) -> usize {
        let view =
            json!({ "buffer": 0, "byteOffset": self.buffer.len(), "byteLength": bytes.len() });
        self.buffer.extend(bytes);
        self.buffer.resize(self.buffer.len().next_multiple_of(4), 0);
        push(&mut self.views, view)
    }

    /// A node with a mesh, or without.
    pub fn node(&mut self, name: &str, at: Transform, mesh: Option<usize>) -> usize {
        let mut node = json!({
            "name": name,
            "translation": at.translation.to_array(),
            "rotation": at.rotation.to_array(),
            "scale": at.scale.to_array(),
        });
        if let Some(mesh) = mesh {
            node["mesh"] = mesh.into();
        }
        push(&mut self.nodes, node)
    }

    pub fn extras(&mut self, node: usize, extras: Value) {
        self.nodes[node]["extras"] = extras;
    }

    pub fn adopt(&mut self, parent: usize, child: usize) {
        let node = self.nodes[parent].as_object_mut().unwrap();
        let children = node.entry("children").or_insert_with(|| json!([]));
        children.as_array_mut().unwrap().push(child.into());
    }

    pub fn text(&self) -> String {
        let children: Vec<&Value> = (self.nodes.iter())
            .filter_map(|node| node.get("children")?.as_array())
            .flatten()
            .collect();
        let tops: Vec<usize> = (0..self.nodes.len())
            .filter(|node| !children.contains(&&Value::from(*node)))
            .collect();
        let buffer = BASE64_STANDARD.encode(&self.buffer);
        let mut file = json!({
            "asset": { "version": "2.0" },
            "scene": 0,
            "scenes": [{ "nodes": tops }],
            "nodes": self.nodes,
            "meshes": self.meshes,
        });
        let lists = [
            ("materials", &self.materials),
            ("accessors", &self.accessors),
            ("bufferViews", &self.views),
        ];
        // An empty list is not allowed.
        for (name, list) in lists {
            if !list.is_empty() {
                file[name] = list.clone().into();
            }
        }
        if !self.buffer.is_empty() {
            file["buffers"] = json!([{
                "byteLength": self.buffer.len(),
                "uri": format!("data:application/octet-stream;base64,{buffer}"),
            }]);
        }
        file.to_string()
    }
}

fn push(list: &mut Vec<Value>, new: Value) -> usize {
    list.push(new);
    list.len() - 1
}
