//! What is shown of the substrate, as meshes that carry maps, or what their file says.

use std::collections::{BTreeMap, HashMap};

use super::frame::{Frame, unturned};
use super::shown::Shown;
use super::{Baked, Baker, order};
use crate::export::{Stance, TexturedMesh, TexturedObject, TriMesh};
use crate::substrate::Part;

/// What vertices may differ in.
#[derive(Clone, Copy)]
struct Corner {
    uv: [f32; 2],
    normal: [f32; 3],
    tangent: [f32; 4],
    second_uv: [f32; 2],
    color: [f32; 3],
}

/// Bits of all that: the substrate's vertex, and the corner.
type Key = (u32, [u32; 14]);

impl Corner {
    fn bits(&self) -> [u32; 14] {
        let all = self.uv.iter().chain(&self.normal).chain(&self.tangent);
        let mut all = all.chain(&self.second_uv).chain(&self.color);
        std::array::from_fn(|_| all.next().map_or(0, |x| x.to_bits()))
    }
}

/// A mesh that is being made, and its vertices by what they are.
#[derive(Default)]
struct Making {
    mesh: TexturedMesh,
    /// One that its triangles are of.
    part: Option<usize>,
    seen: HashMap<Key, u32>,
}

/// A mesh of an object as its file has it, and its material in the file, if it has one.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnMesh {
    /// The object that it is of.
    pub object: TexturedObject,
    /// The place of its material.
    pub material: Option<usize>,
    /// What that is called, if it has a name.
    pub material_name: Option<String>,
    /// Its shape, with coordinates and tangents.
    pub mesh: TexturedMesh,
}

impl Baked<'_> {
    /// What is shown of the substrate, object by object: wound outwards, with vertices split where UVs, normals or
    /// tangents differ, in the units and axes of its file, with both sets of UVs, or with charts of their own and the
    /// file's first set. Triangles without UVs are at (0, 0).
    pub fn meshes(&self) -> Vec<(TexturedObject, TexturedMesh)> {
        let cutter = Cutter {
            shown: self.shown.clone(),
            frames: &self.frames,
            is_own: false,
        };
        let meshes = cutter.meshes().into_iter();
        meshes.map(|own| (own.object, own.mesh)).collect()
    }
}

impl Baker<'_> {
    /// A part without maps, object by object and material by material, as [`Baked::meshes`] but for tangents: with the
    /// colours of vertices, as far as the file has them.
    pub fn own_meshes(&self, chosen: Option<&[bool]>) -> Vec<OwnMesh> {
        let shown = self.shown(chosen);
        let frames = unturned(&shown);
        let cutter = Cutter {
            shown,
            frames: &frames,
            is_own: true,
        };
        cutter.meshes()
    }
}

/// Cuts what is shown into meshes.
struct Cutter<'a> {
    shown: Shown<'a>,
    frames: &'a [Frame],
    /// Whether they go without maps.
    is_own: bool,
}

impl Cutter<'_> {
    fn meshes(&self) -> Vec<OwnMesh> {
        let (objects, of_parts) = self.objects();
        let mut all: BTreeMap<(usize, Option<usize>), Making> = BTreeMap::new();
        for triangle in self.shown.triangles() {
            let part = self.shown.part_of(triangle).map(|part| part as usize);
            let object = part.map_or(objects.len() - 1, |part| of_parts[part]);
            let material = self.shown.material_of(triangle).filter(|_| self.is_own);
            let making = all.entry((object, material)).or_default();
            making.part = part;
            self.add(triangle, making);
        }
        let parts = &self.shown.texturing.parts;
        let own = |((object, material), making): ((usize, _), Making)| OwnMesh {
            object: objects[object].clone(),
            material,
            material_name: making.part.and_then(|part| parts[part].material.clone()),
            mesh: making.mesh,
        };
        all.into_iter().map(own).collect()
    }

    /// The objects that parts of the file belong to, and of each part its object's place; last is one for what belongs
    /// to no part.
    fn objects(&self) -> (Vec<TexturedObject>, Vec<usize>) {
        let mut objects: Vec<TexturedObject> = Vec::new();
        let mut places = HashMap::new();
        let mut place = |part: &Part| {
            let name = part.objects.first().cloned();
            let bits = |frame: [[f64; 3]; 4]| frame.map(|column| column.map(f64::to_bits));
            let key = (name.clone(), part.frame.map(bits));
            *places.entry(key).or_insert_with(|| {
                objects.push(TexturedObject {
                    name,
                    stance: part.frame.and_then(Stance::from_columns),
                    meshes: Vec::new(),
                });
                objects.len() - 1
            })
        };
        let parts = self.shown.texturing.parts.iter();
        let of_parts = parts.map(&mut place).collect();
        objects.push(TexturedObject::default());
        (objects, of_parts)
    }

    fn add(&self, triangle: u32, making: &mut Making) {
        making.mesh.shape.up = self.shown.substrate.up_axis();
        let turned = self.shown.substrate.winding().side(triangle) < 0.0;
        let corners = self.corners(triangle);
        let vertices = order(turned).map(|k| self.vertex(triangle, (k, &corners[k]), making));
        making.mesh.shape.triangles.push(vertices);
    }

    fn corners(&self, triangle: u32) -> [Corner; 3] {
        let (substrate, texturing) = (self.shown.substrate, self.shown.texturing);
        let narrow = |uvs: [[f64; 2]; 3]| uvs.map(|uv| uv.map(|x| x as f32));
        let uvs = self.shown.uvs_of(triangle).map_or([[0.0; 2]; 3], narrow);
        let own = self.is_own.then_some(triangle);
        let second = self.shown.second_uvs_of(triangle);
        let second = second.map_or([[0.0; 2]; 3], narrow);
        let colors = own.and_then(|t| texturing.colors_of(substrate, t));
        let colors = colors.unwrap_or([[1.0; 3]; 3]);
        let frame = &self.frames[triangle as usize];
        std::array::from_fn(|k| Corner {
            uv: uvs[k],
            normal: frame.normals[k].to_array(),
            tangent: if self.is_own {
                [0.0; 4]
            } else {
                frame.tangents[k].to_array()
            },
            second_uv: second[k],
            color: colors[k],
        })
    }

    fn vertex(
        &self,
        triangle: u32,
        (k, corner): (usize, &Corner),
        Making { mesh, seen, .. }: &mut Making,
    ) -> u32 {
        let substrate = self.shown.substrate;
        let vertex = substrate.triangles()[triangle as usize][k];
        *seen.entry((vertex, corner.bits())).or_insert_with(|| {
            let place = substrate.vertices()[vertex as usize];
            let place = substrate.units().to_file(place);
            let TriMesh {
                positions, normals, ..
            } = &mut mesh.shape;
            positions.push(place.to_array());
            normals.push(corner.normal);
            mesh.uvs.push(corner.uv);
            if !self.is_own {
                mesh.tangents.push(corner.tangent);
            }
            if self.shown.has_second_uvs() {
                mesh.second_uvs.push(corner.second_uv);
            }
            if self.is_own && !self.shown.texturing.colors.is_empty() {
                mesh.colors.push(corner.color);
            }
            positions.len() as u32 - 1
        })
    }
}
