//! One glTF mesh primitive, placed in the world once or many times.

use std::collections::HashMap;
use std::rc::Rc;

use glam::{DAffine3, DMat3, DVec3};

use crate::substrate::texturing::{Corner, Of};
use crate::substrate::{Soup, Texturing};

use super::error::{LoadFault, Parsed};
use super::exclusive_index;
use super::gltf_accessor::Accessors;
use super::gltf_buffers::EXPORT_AGAIN;
use super::gltf_morph::Morphs;
use super::gltf_schema::Primitive;
use super::gltf_skin::{Pose, all_accessors_of};
use super::text::used_are_finite;

/// Copies, vertices and corners that a document may have beyond what its bytes could hold: instances
/// multiply a mesh, and a few kilobytes must not fill the memory.
const MOST_REPEATED: usize = 1 << 25;

/// Collects the triangles of a document.
pub(super) struct Collector<'a> {
    pub(super) accessors: Accessors<'a>,
    pub(super) soup: Soup,
    pub(super) passed_over: Tally,
    /// Texture coordinates, where they are asked for.
    pub(super) texturing: Option<Texturing>,
    /// Of the next primitive.
    pub(super) of: Of,
    /// Where the vertices came from, in their order.
    origins: Vec<Origin>,
    used: usize,
}

/// Where vertices came from: those of a position accessor, once for each transform.
struct Origin {
    placed: Placed,
    place: String,
    accessor: usize,
}

/// What was met and not used, by count.
#[derive(Default)]
pub(super) struct Tally {
    /// Nodes with a mesh that are not to be seen.
    pub(super) hidden: usize,
    pub(super) points: usize,
    pub(super) lines: usize,
    pub(super) without_positions: usize,
    pub(super) leftover_indices: usize,
    /// Primitives whose morph targets move them, and others that have such.
    pub(super) morphed: usize,
    pub(super) unmorphed: usize,
    /// Skinned meshes, in the pose of their joints and without it.
    pub(super) posed: usize,
    pub(super) skinned: usize,
}

/// Where the vertices of a position accessor went: `count` for each transform, from `start`.
#[derive(Clone, Copy)]
struct Placed {
    start: usize,
    count: usize,
}

/// The vertices that the primitives of one node's mesh share.
#[derive(Default)]
pub(super) struct SharedPositions(HashMap<Source, Posed>);

/// The accessors that a primitive's vertices come from.
#[derive(PartialEq, Eq, Hash)]
struct Source {
    position: usize,
    /// Of the joints and weights that move them.
    joints: Vec<[usize; 2]>,
    /// Of the morph targets that do, after their numbers.
    targets: Vec<[usize; 2]>,
}

/// Vertices that were placed, and the sense that joints gave each of them ([`Pose::apply`]); none where no joint turns
/// anything inside out.
#[derive(Clone)]
struct Posed {
    placed: Placed,
    senses: Rc<[f64]>,
}

/// What was done to one instance of a primitive.
struct Instance<'a> {
    mirrored: bool,
    senses: &'a [f64],
    /// What turns its normals, if that is known.
    turn: Option<DMat3>,
}

impl Instance<'_> {
    /// Whether a triangle of it is turned inside out: as most of it is where joints differ.
    fn mirrors(&self, corners: [u32; 3]) -> bool {
        let sense = |v: u32| self.senses.get(v as usize).copied().unwrap_or(1.0);
        self.mirrored || corners.map(sense).iter().sum::<f64>() < 0.0
    }

    /// The triangle as it faces then.
    fn facing(&self, [a, b, c]: [u32; 3]) -> [u32; 3] {
        match self.mirrors([a, b, c]) {
            true => [a, c, b],
            false => [a, b, c],
        }
    }
}

/// Where a node's mesh goes.
pub(super) struct Placing<'a> {
    /// What its targets add to it before.
    pub(super) morphs: Morphs<'a>,
    /// Once for each of these.
    pub(super) transforms: Vec<DAffine3>,
    /// Or where joints take it.
    pub(super) pose: Option<Pose>,
}

impl Placing<'_> {
    /// The transforms of a primitive's triangles, and the joints that have moved them before.
    fn of(&self, primitive: &Primitive) -> (&[DAffine3], Option<&Pose>) {
        match self.pose.as_ref().filter(|_| Pose::moves(primitive)) {
            Some(pose) => (&[DAffine3::IDENTITY], Some(pose)),
            None => (&self.transforms, None),
        }
    }
}

/// The order in which a primitive's corners are visited.
enum Corners {
    InOrder(usize),
    Indexed(Vec<u32>),
}

impl Corners {
    fn len(&self) -> usize {
        match self {
            Self::InOrder(count) => *count,
            Self::Indexed(indices) => indices.len(),
        }
    }

    fn get(&self, i: usize) -> u32 {
        match self {
            Self::InOrder(_) => i as u32,
            Self::Indexed(indices) => indices[i],
        }
    }
}

impl<'a> Collector<'a> {
    pub(super) fn new(accessors: Accessors<'a>, textured: bool) -> Self {
        Self {
            accessors,
            soup: Soup::default(),
            passed_over: Tally::default(),
            texturing: textured.then(Texturing::default),
            of: Of::default(),
            origins: Vec::new(),
            used: 0,
        }
    }

    /// Adds the primitive's triangles, once for each transform.
    pub(super) fn primitive(
        &mut self,
        primitive: &Primitive,
        place: &str,
        placing: &Placing,
        shared: &mut SharedPositions,
    ) -> Parsed<()> {
        let (transforms, pose) = placing.of(primitive);
        if !self.has_triangles(primitive, place)? {
            return Ok(());
        }
        let Some(&position) = primitive.attributes.get("POSITION") else {
            self.passed_over.without_positions += 1;
            return Ok(());
        };
        self.refuse_draco(primitive, position, place)?;
        let source = Source {
            position,
            joints: pose.map_or_else(Vec::new, |_| all_accessors_of(primitive)),
            targets: placing.morphs.movers(primitive, "POSITION"),
        };
        if !primitive.targets.is_empty() {
            self.passed_over.morphed += usize::from(!source.targets.is_empty());
            self.passed_over.unmorphed += usize::from(source.targets.is_empty());
        }
        let posed = match shared.0.get(&source) {
            Some(posed) => posed.clone(),
            None => self.place_vertices(primitive, position, place, placing)?,
        };
        shared.0.insert(source, posed.clone());
        let Posed { placed, senses } = posed;
        let corners = self.corners(primitive, placed, place)?;
        let elements = corners.len().saturating_add(1);
        self.charge(elements.saturating_mul(transforms.len()), place)?;
        let turns_normals = pose.is_none() && self.texturing.is_some();
        // Instances of nothing are many in no time.
        let used = transforms.iter().filter(|_| corners.len() > 0);
        let copies = used.map(|transform| Instance {
            mirrored: mirrors(transform),
            senses: &senses,
            turn: turns_normals.then(|| of_normals(transform)).flatten(),
        });
        let copies: Vec<Instance> = copies.collect();
        for (number, copy) in copies.iter().enumerate() {
            let base = (placed.start + number * placed.count) as u32;
            let triangles = &mut self.soup.triangles;
            assemble(primitive.mode, &corners, triangles, |corners| {
                copy.facing(corners).map(|corner| corner + base)
            });
        }
        self.texture(primitive, &corners, placed.count, place, (placing, &copies))?;
        self.passed_over.leftover_indices += match primitive.mode {
            4 => corners.len() % 3,
            _ => 0,
        };
        Ok(())
    }

    /// Adds the texture coordinates and normals of the triangles that were added, in the same order.
    fn texture(
        &mut self,
        primitive: &Primitive,
        corners: &Corners,
        vertices: usize,
        place: &str,
        (placing, copies): (&Placing, &[Instance]),
    ) -> Parsed<()> {
        let Some(mut texturing) = self.texturing.take() else {
            return Ok(());
        };
        self.accessors.buffers.read_looks(true);
        let uvs = self.texcoords(primitive, "TEXCOORD_0", vertices, place)?;
        // Nothing but textures needs the second set, so a broken one is passed over.
        let second = self.texcoords(primitive, "TEXCOORD_1", vertices, place);
        let uvs = [uvs, second.unwrap_or_default()];
        let normals = self.normals(primitive, place, &placing.morphs);
        let colors = ["COLOR_0", "COLOR_1"].map(|set| self.colors(primitive, set, place));
        self.accessors.buffers.read_looks(false);
        for copy in copies {
            let mut triangles = Vec::new();
            assemble(primitive.mode, corners, &mut triangles, |corners| {
                copy.facing(corners)
            });
            let turned =
                |normal: &[f64; 3]| Some((copy.turn? * DVec3::from_array(*normal)).to_array());
            let corner = |v: u32| Corner {
                uvs: uvs.each_ref().map(|set| Some(set.as_ref()?[v as usize])),
                normal: normals.get(v as usize).and_then(turned),
                colors: colors.each_ref().map(|set| set.get(v as usize).copied()),
            };
            triangles
                .into_iter()
                .for_each(|t| texturing.push(t.map(corner), self.of));
        }
        self.texturing = Some(texturing);
        Ok(())
    }

    fn texcoords(
        &self,
        primitive: &Primitive,
        set: &str,
        vertices: usize,
        place: &str,
    ) -> Parsed<Option<Vec<[f64; 2]>>> {
        let Some(&accessor) = primitive.attributes.get(set) else {
            return Ok(None);
        };
        let uvs = self.accessors.vectors(accessor, place)?;
        if uvs.len() < vertices {
            let problem = format!("{set} has {} places for {vertices} vertices", uvs.len());
            return Err(self.fault(place, problem));
        }
        Ok(Some(uvs))
    }

    /// Those of the vertices, which are of linear light. A mesh can do without them, so broken ones are passed over.
    fn colors(&self, primitive: &Primitive, set: &str, place: &str) -> Vec<[f32; 3]> {
        let Some(&accessor) = primitive.attributes.get(set) else {
            return Vec::new();
        };
        let opaque = |four: Vec<[f64; 4]>| four.into_iter().map(|[r, g, b, _]| [r, g, b]).collect();
        let three = self.accessors.vectors(accessor, place);
        let read = three.or_else(|_| self.accessors.vectors(accessor, place).map(opaque));
        let is_sound = |colors: &Vec<[f64; 3]>| colors.iter().flatten().all(|x| x.is_finite());
        let sound = read.ok().filter(is_sound).unwrap_or_default();
        let light = |color: [f64; 3]| color.map(|x| x.clamp(0.0, 1.0) as f32);
        sound.into_iter().map(light).collect()
    }

    /// Those of the vertices. A mesh can do without them, so broken ones are passed over.
    fn normals(&self, primitive: &Primitive, place: &str, morphs: &Morphs) -> Vec<[f64; 3]> {
        let Some(&accessor) = primitive.attributes.get("NORMAL") else {
            return Vec::new();
        };
        let all = &self.accessors;
        let moved = all.vectors(accessor, place).and_then(|mut normals| {
            morphs.apply(primitive, "NORMAL", all, place, &mut normals)?;
            Ok(normals)
        });
        moved.unwrap_or_default()
    }

    fn has_triangles(&mut self, primitive: &Primitive, place: &str) -> Parsed<bool> {
        match primitive.mode {
            0 => self.passed_over.points += 1,
            1..=3 => self.passed_over.lines += 1,
            4..=6 => return Ok(true),
            mode => return Err(self.fault(place, format!("primitive mode {mode} is unknown"))),
        }
        Ok(false)
    }

    /// Draco data has no uncompressed accessor behind it, unless the exporter kept one.
    fn refuse_draco(&self, primitive: &Primitive, position: usize, place: &str) -> Parsed<()> {
        if primitive.extensions.draco.is_none() {
            return Ok(());
        }
        let needed = [Some(position), primitive.indices];
        for index in needed.into_iter().flatten() {
            if self.accessors.get(index, place)?.buffer_view.is_none() {
                return Err(LoadFault::Unsupported {
                    format: self.accessors.format,
                    place: place.into(),
                    feature: "KHR_draco_mesh_compression".into(),
                    cure: "export again without Draco compression (in Blender: untick \
                           Compression; with glTF-Transform: `gltf-transform copy IN OUT`)"
                        .into(),
                });
            }
        }
        Ok(())
    }

    /// Appends the vertices, as often as there are transforms.
    fn place_vertices(
        &mut self,
        primitive: &Primitive,
        accessor: usize,
        place: &str,
        placing: &Placing,
    ) -> Parsed<Posed> {
        let (transforms, pose) = placing.of(primitive);
        let count = self.accessors.get(accessor, place)?.count;
        let start = self.soup.positions.len();
        self.accessors
            .append_vectors(accessor, place, &mut self.soup.positions)?;
        self.charge(count.saturating_mul(transforms.len()), place)?;
        let positions = &mut self.soup.positions;
        // Indices beyond u32 would wrap in `assemble`.
        let total = count.saturating_mul(transforms.len()).saturating_add(start);
        exclusive_index(total, self.accessors.format)?;
        positions.reserve(total - positions.len());
        let (all, morphs) = (&self.accessors, &placing.morphs);
        morphs.apply(primitive, "POSITION", all, place, &mut positions[start..])?;
        let senses = match pose {
            Some(pose) => pose.apply(primitive, all, place, &mut positions[start..])?,
            None => Vec::new(),
        };
        for transform in transforms.iter().skip(1).filter(|_| count > 0) {
            for vertex in start..start + count {
                let moved = moved(transform, positions[vertex]);
                positions.push(moved);
            }
        }
        for position in &mut positions[start..start + count] {
            *position = moved(&transforms[0], *position);
        }
        let placed = Placed { start, count };
        self.origins.push(Origin {
            placed,
            place: place.to_owned(),
            accessor,
        });
        let senses = senses.into();
        Ok(Posed { placed, senses })
    }

    /// Refuses triangles with a corner that is no place in space.
    pub(super) fn refuse_endless(&mut self) -> Parsed<()> {
        let origins = &self.origins;
        used_are_finite(&mut self.soup, self.accessors.format, |vertex| {
            let after = origins.partition_point(|o| o.placed.start <= vertex);
            let Origin {
                placed,
                place,
                accessor,
            } = &origins[after - 1];
            let vertex = (vertex - placed.start) % placed.count;
            format!("{place}, accessor {accessor}, vertex {vertex}")
        })
    }

    fn corners(&self, primitive: &Primitive, placed: Placed, place: &str) -> Parsed<Corners> {
        let Some(accessor) = primitive.indices else {
            return Ok(Corners::InOrder(placed.count));
        };
        let indices = self.accessors.indices(accessor, place)?;
        match indices.iter().position(|&i| i as usize >= placed.count) {
            None => Ok(Corners::Indexed(indices)),
            Some(at) => Err(LoadFault::malformed(
                self.accessors.format,
                format!("{place}, accessor {accessor}, index {at}"),
                format!(
                    "vertex {} is named, but there are {}",
                    indices[at], placed.count
                ),
                EXPORT_AGAIN,
            )),
        }
    }

    pub(super) fn charge(&mut self, elements: usize, place: &str) -> Parsed<()> {
        self.used = self.used.saturating_add(elements);
        if self.used > MOST_REPEATED
            && self.used - MOST_REPEATED > self.accessors.buffers.most_elements()
        {
            let problem = "the instances of this file's meshes unfold to more than 33 million \
                           copies, vertices and corners";
            return Err(LoadFault::malformed(
                self.accessors.format,
                place,
                problem,
                "export only the object to grow on",
            ));
        }
        Ok(())
    }

    fn fault(&self, place: &str, problem: String) -> LoadFault {
        LoadFault::malformed(self.accessors.format, place, problem, EXPORT_AGAIN)
    }
}

fn mirrors(transform: &DAffine3) -> bool {
    transform.matrix3.determinant() < 0.0
}

/// What turns normals as this turns places; none where it flattens them.
fn of_normals(transform: &DAffine3) -> Option<DMat3> {
    let turn = transform.matrix3.inverse().transpose();
    turn.is_finite().then_some(turn)
}

fn moved(transform: &DAffine3, position: [f64; 3]) -> [f64; 3] {
    transform
        .transform_point3(DVec3::from_array(position))
        .to_array()
}

/// Appends the triangles of a list (4), strip (5) or fan (6), wound as section 3.7.2.1 of the
/// specification says.
fn assemble(
    mode: u32,
    corners: &Corners,
    out: &mut Vec<[u32; 3]>,
    place: impl Fn([u32; 3]) -> [u32; 3],
) {
    let corner = |i: usize| corners.get(i);
    let triangles = corners.len().saturating_sub(2);
    match mode {
        5 => out.extend((0..triangles).map(|i| {
            let odd = i % 2;
            place([corner(i), corner(i + 1 + odd), corner(i + 2 - odd)])
        })),
        6 => {
            out.extend((0..triangles).map(|i| place([corner(0), corner(i + 1), corner(i + 2)])));
        }
        _ => {
            let triangles = corners.len() / 3;
            out.reserve(triangles);
            out.extend(
                (0..triangles)
                    .map(|t| place([corner(3 * t), corner(3 * t + 1), corner(3 * t + 2)])),
            );
        }
    }
}
