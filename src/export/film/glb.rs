//! A film as binary glTF: a node a frame, shown and hidden by its scale, which steps between 0 and 1
//! (Khronos, *glTF 2.0 Specification*, 3.11). A node that is hidden is a place, which programs take into the box
//! of all: so places are stored from the middle of the lichen. Skins are whole in each frame. Of points and curves a
//! node has those whose influence comes to a half, and stays. Without the animation, as in a viewer
//! that plays none, the last frame shows.

use std::io::{self, Write};

use serde_json::{Map, Value, json};

use super::{NOTHING, Spool, Spools, invalid};
use crate::color::to_linear;
use crate::export::glb::{LINES, POINTS, VERTICES, document, write_head};
use crate::export::mesh::glb::{Parts, write_body};
use crate::export::{AgeColor, Scene, TriMesh, What};

#[derive(Debug)]
pub(super) struct Glb {
    spools: Spools,
    body: Option<Spool>,
    parts: Parts,
    /// The number of the first frame.
    pub(super) first: u32,
    /// Where hidden frames are.
    origin: Option<[f64; 3]>,
    meshes: Vec<Value>,
    /// For each frame its mesh, if there is something to see that was not there before.
    frames: Vec<Option<usize>>,
    /// Whether what a frame brings stays in those after it.
    stays: bool,
    /// Elements that have come so far.
    come: usize,
}

impl Glb {
    pub(super) fn new(spools: Spools) -> Self {
        Self {
            spools,
            body: None,
            parts: Parts::default(),
            first: 1,
            origin: None,
            meshes: Vec::new(),
            frames: Vec::new(),
            stays: false,
            come: 0,
        }
    }

    pub(super) fn lies_about(&mut self, whole: &TriMesh) {
        self.origin = Some(middle(whole.origin(), whole.bounds()));
    }

    pub(super) fn add_skin(&mut self, mesh: &TriMesh) -> io::Result<()> {
        if mesh.triangles.is_empty() {
            self.frames.push(None);
            return Ok(());
        }
        if self.origin.is_none() {
            self.lies_about(mesh);
        }
        let origin = self.origin.unwrap_or_default();
        let primitive = self.parts.describe(mesh, origin);
        self.add_mesh(primitive, |out| write_body(mesh, origin, out))
    }

    fn add_mesh(
        &mut self,
        primitive: Value,
        body: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> io::Result<()> {
        let name = self.frame_name(self.frames.len());
        self.frames.push(Some(self.meshes.len()));
        self.meshes
            .push(json!({"name": name, "primitives": [primitive]}));
        if self.body.is_none() {
            self.body = Some(self.spools.make()?);
        }
        match &mut self.body {
            Some(spool) => body(&mut spool.0),
            None => Ok(()),
        }
    }

    fn frame_name(&self, frame: usize) -> String {
        format!("frame {:04}", u64::from(self.first) + frame as u64)
    }

    pub(super) fn add_scene(
        &mut self,
        what: What,
        scene: &Scene,
        color: AgeColor<'_>,
    ) -> io::Result<()> {
        self.stays = true;
        let found = || middle(scene.origin(), scene.bounds());
        let origin = *self.origin.get_or_insert_with(found);
        let there = scene.influences().partition_point(|x| *x >= 0.5);
        let new = self.come.min(there)..there;
        let of: Vec<usize> = match what {
            What::Curves => links(scene, new),
            _ => new.collect(),
        };
        self.come = there.max(self.come);
        if of.is_empty() {
            self.frames.push(None);
            return Ok(());
        }
        let columns = columns(scene, color, &of, origin);
        let mut attributes = Map::new();
        for (name, width, values) in &columns {
            let accessor = self.parts.floats(*width, values, Some(VERTICES));
            attributes.insert((*name).to_owned(), accessor.into());
        }
        let mode = if what == What::Curves { LINES } else { POINTS };
        let primitive = json!({"attributes": attributes, "mode": mode, "material": 0});
        self.add_mesh(primitive, |out| {
            let values = columns.iter().flat_map(|(.., values)| values);
            values
                .into_iter()
                .try_for_each(|x| out.write_all(&x.to_le_bytes()))
        })
    }

    pub(super) fn write(mut self, fps: f64, out: &mut dyn Write) -> io::Result<()> {
        let Some(last) = self.frames.iter().rposition(Option::is_some) else {
            return Err(invalid(NOTHING));
        };
        let (mut nodes, mut samplers, mut channels) = (Vec::new(), Vec::new(), Vec::new());
        let mut tail: Vec<f32> = Vec::new();
        for (frame, mesh) in self.frames.iter().enumerate() {
            let Some(mesh) = mesh else { continue };
            let remains = self.stays || frame == last;
            let end = (frame == last && self.frames.len() > 1).then_some(self.frames.len());
            let [times, scales] = steps(frame, fps, remains, end);
            if times.len() > 1 {
                let input = self.parts.floats(1, &times, None);
                let output = self.parts.floats(3, &scales, None);
                tail.extend(times.into_iter().chain(scales));
                channels.push(json!({
                    "sampler": samplers.len(), "target": {"node": nodes.len(), "path": "scale"},
                }));
                samplers.push(json!({"input": input, "output": output, "interpolation": "STEP"}));
            }
            let mut node = json!({"name": self.frame_name(frame), "mesh": mesh});
            if !remains {
                node["scale"] = json!([0, 0, 0]);
            }
            nodes.push(node);
        }
        let animation = json!({"name": "growth", "samplers": samplers, "channels": channels});
        self.finish(nodes, animation, &tail, out)
    }

    fn finish(
        self,
        mut nodes: Vec<Value>,
        animation: Value,
        tail: &[f32],
        out: &mut dyn Write,
    ) -> io::Result<()> {
        let frames: Vec<usize> = (0..nodes.len()).collect();
        let mut root = json!({"name": "lichen", "children": frames});
        let origin = self.origin.unwrap_or_default();
        if origin != [0.0; 3] {
            root["translation"] = json!(origin);
        }
        nodes.push(root);
        let mut document = document(Value::Null, Value::Null);
        document["scenes"] = json!([{"nodes": [nodes.len() - 1]}]);
        document["nodes"] = nodes.into();
        document["meshes"] = self.meshes.into();
        if animation["channels"]
            .as_array()
            .is_some_and(|c| !c.is_empty())
        {
            document["animations"] = json!([animation]);
        }
        let size = self.parts.describe_in(&mut document);
        write_head(&document, size, out)?;
        if let Some(body) = self.body {
            body.pour(out)?;
        }
        tail.iter()
            .try_for_each(|x| out.write_all(&x.to_le_bytes()))
    }
}

/// The middle of a box, which is that of places from an origin where 32 bits would not say them. Where they do, it
/// is a number of 32 bits, by which programs move places without rounding it.
fn middle(origin: [f64; 3], [low, high]: [[f64; 3]; 2]) -> [f64; 3] {
    match origin == [0.0; 3] {
        true => [0, 1, 2].map(|k| f64::from((0.5 * low[k] + 0.5 * high[k]) as f32)),
        false => origin,
    }
}

/// Times in seconds, and the scales from each on, that show a frame. The last to come has a key at the
/// end of the film too: players that repeat begin again at the last key, and would never show it.
fn steps(frame: usize, fps: f64, remains: bool, end: Option<usize>) -> [Vec<f32>; 2] {
    let at = |frame: usize| (frame as f64 / fps) as f32;
    let mut steps = vec![(at(frame), 1.0)];
    if frame > 0 {
        steps.insert(0, (0.0, 0.0));
    }
    if !remains {
        steps.push((at(frame + 1), 0.0));
    }
    steps.extend(end.map(|end| (at(end), 1.0)));
    let times = steps.iter().map(|(time, _)| *time).collect();
    [
        times,
        steps.iter().flat_map(|(_, scale)| [*scale; 3]).collect(),
    ]
}

/// The ends of the links to these elements from their parents, one after the other.
fn links(scene: &Scene, of: std::ops::Range<usize>) -> Vec<usize> {
    let parent = |i: usize| usize::try_from(scene.elements.parent[i]).ok();
    let link = |i: usize| parent(i).map(|parent| [parent, i]);
    of.filter_map(link).flatten().collect()
}

/// Attributes of vertices: their names, widths and values.
type Columns = Vec<(&'static str, usize, Vec<f32>)>;

fn columns(scene: &Scene, color: AgeColor<'_>, of: &[usize], origin: [f64; 3]) -> Columns {
    let elements = &scene.elements;
    let place = |&i: &usize| {
        let p = elements.positions[i];
        [0, 1, 2].map(|k| (p[k] - origin[k]) as f32)
    };
    let vectors = |of: &dyn Fn(&usize) -> [f32; 3], list: &[usize]| -> Vec<f32> {
        list.iter().flat_map(of).collect()
    };
    let normal = |&i: &usize| elements.normals[i];
    let light = |&i: &usize| color(elements.age(i)).map(to_linear);
    let radius = elements.radius as f32;
    vec![
        ("POSITION", 3, vectors(&place, of)),
        ("NORMAL", 3, vectors(&normal, of)),
        ("COLOR_0", 3, vectors(&light, of)),
        ("_BIRTH", 1, of.iter().map(|&i| i as f32).collect()),
        ("_RADIUS", 1, vec![radius; of.len()]),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_frame_lasts_as_long_as_the_others() {
        let [times, scales] = steps(3, 2.0, true, Some(4));
        assert_eq!(times, [0.0, 1.5, 2.0]);
        assert_eq!(scales, [[0.0; 3], [1.0; 3], [1.0; 3]].concat());
        // Frames at the end that bring nothing new last too.
        assert_eq!(steps(3, 2.0, true, Some(6))[0], [0.0, 1.5, 3.0]);
        assert_eq!(steps(1, 2.0, false, None)[0], [0.0, 0.5, 1.0]);
    }
}
