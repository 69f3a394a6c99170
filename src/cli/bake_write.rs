//! What `thallus bake` puts into its folder.

use std::collections::{HashMap, HashSet};
use std::ffi::OsStr;
use std::fs;
use std::io;
use std::path::Path;

use rayon::prelude::*;
use serde_json::{Value, json};
use thallus::bake::{Baked, Baker, Green, MAPS, Map, MapFile, MapFormat, MapKind, OwnMesh};
use thallus::export::{
    OutputDir, OutputError, Placement, SurfaceLook, TexturedMaterial, TexturedScene,
};
use thallus::substrate::Texturing;

use super::bake_args::BakeArgs;
use super::bake_parts::MapPart;
use super::interrupt::Stop;

pub(crate) const GLB: &str = "lichened.glb";
const SIDECAR: &str = "maps.json";

/// Writes maps, part by part, and at the end the mesh that wears them.
pub(crate) struct Writer<'a> {
    placement: &'a Placement,
    format: MapFormat,
    size: u32,
    scene: TexturedScene,
    /// What the maps of each part are.
    parts: Vec<Value>,
    files: Vec<String>,
    /// Places in the scene of materials, and of images, of the mesh's file.
    own: HashMap<Option<usize>, usize>,
    own_images: HashMap<usize, usize>,
}

impl<'a> Writer<'a> {
    /// For a mesh of this name.
    pub(crate) fn new(args: &BakeArgs, name: &str, placement: &'a Placement) -> Self {
        Self {
            placement,
            format: MapFormat {
                file: args.maps.format.into(),
                green: args.maps.normal.into(),
                meters_per_unit: placement.scale,
            },
            size: args.maps.size,
            scene: TexturedScene::new(name),
            parts: Vec::new(),
            files: Vec::new(),
            own: HashMap::new(),
            own_images: HashMap::new(),
        }
    }

    /// The files that have been written so far.
    pub(crate) fn files(&self) -> &[String] {
        &self.files
    }

    /// Writes the maps of a part, and says what they are called.
    pub(crate) fn write(
        &mut self,
        folder: &mut OutputDir,
        stop: &Stop,
        (part, baked): (&MapPart, &Baked),
    ) -> Result<Vec<String>, OutputError> {
        let file_name = |map: &Map| part.file_name(map.name, self.format.file.extension());
        let encoded = |map: &Map| {
            let mut file = Vec::new();
            stop.check()?;
            baked.write_map(map, &self.format, &mut file)?;
            Ok((map.kind, file))
        };
        let files: Vec<io::Result<(MapKind, Vec<u8>)>> = MAPS.par_iter().map(encoded).collect();
        let names: Vec<String> = MAPS.iter().map(file_name).collect();
        let mut written = Vec::new();
        for (name, file) in names.iter().zip(files) {
            folder.write(name, |out| {
                stop.check()?;
                let file = file?;
                out.write_all(&file.1)?;
                written.push(file);
                Ok(())
            })?;
        }
        if self.format.file != MapFile::Png {
            written.clear();
        }
        let mesh = &self.scene.name;
        let material = baked.material(part.material.as_ref().unwrap_or(mesh), &written);
        let mut material = material.map_err(|problem| OutputError::Io {
            path: folder.path().join(GLB),
            doing: "writing",
            problem,
        })?;
        if let SurfaceLook::Maps(images) = &mut material.look {
            images.affixes = part.image_affixes(mesh);
        }
        self.scene.add(material, baked.meshes());
        self.check_size(folder)?;
        self.parts.push(self.described(part, baked));
        self.files.extend_from_slice(&names);
        Ok(names)
    }

    /// Refuses images that no file has room for.
    pub(crate) fn check_size(&self, folder: &OutputDir) -> Result<(), OutputError> {
        if self.scene.image_bytes() > u32::MAX as usize {
            let problem = "a .glb ends at 4 GiB, and its images alone need more: make --size smaller, or bake fewer parts at \
                           once with --only";
            return Err(OutputError::Io {
                path: folder.path().join(GLB),
                doing: "writing",
                problem: io::Error::new(io::ErrorKind::InvalidInput, problem),
            });
        }
        Ok(())
    }

    /// Adds meshes that wear what their file says.
    pub(crate) fn keep(&mut self, meshes: Vec<OwnMesh>, of: (&Baker, &Texturing)) {
        for own in meshes {
            let worn = match self.own.get(&own.material) {
                Some(&worn) => worn,
                None => {
                    let material = self.own_material(&own, of);
                    self.scene.materials.push(material);
                    let worn = self.scene.materials.len() - 1;
                    self.own.insert(own.material, worn);
                    worn
                }
            };
            self.scene.add_meshes(worn, vec![(own.object, own.mesh)]);
        }
    }

    fn own_material(
        &mut self,
        own: &OwnMesh,
        (baker, texturing): (&Baker, &Texturing),
    ) -> TexturedMaterial {
        let look = own.material.map(|number| baker.own_material(number));
        let mut look = look.unwrap_or_default();
        let textures = [
            &mut look.base_color_texture,
            &mut look.metallic_roughness_texture,
            &mut look.normal_texture,
            &mut look.occlusion_texture,
            &mut look.emissive_texture,
        ];
        for texture in textures.into_iter().flatten() {
            let images = &mut self.scene.images;
            texture.image = *self.own_images.entry(texture.image).or_insert_with(|| {
                images.push(texturing.images[texture.image].clone());
                images.len() - 1
            });
        }
        TexturedMaterial {
            name: own.material_name.clone().unwrap_or_default(),
            alpha: look.alpha,
            is_double_sided: look.is_double_sided,
            look: SurfaceLook::Own(Box::new(look)),
        }
    }

    /// Writes what comes once for all parts, and takes away what an earlier bake made and this one did not.
    pub(crate) fn finish(
        &mut self,
        folder: &mut OutputDir,
        stop: &Stop,
    ) -> Result<(), OutputError> {
        self.scene.place(self.placement);
        folder.write(GLB, |out| {
            stop.check()?;
            self.scene.write_glb(out)
        })?;
        let sidecar = self.sidecar();
        folder.write(SIDECAR, |out| {
            serde_json::to_writer_pretty(&mut *out, &sidecar)?;
            out.write_all(b"\n")
        })?;
        self.files.extend([GLB, SIDECAR].map(str::to_owned));
        let made: HashSet<&String> = self.files.iter().collect();
        let earlier = maps_of(&folder.path().join(SIDECAR));
        let others = earlier.iter().filter(|name| !made.contains(name));
        others.for_each(|name| folder.outdate(name));
        Ok(())
    }

    fn described(&self, part: &MapPart, baked: &Baked) -> Value {
        let map = |map: &Map| {
            let meaning = baked.meaning(map, &self.format);
            json!({
                "file": part.file_name(map.name, self.format.file.extension()),
                "what": map.what,
                "color_space": meaning.color_space,
                "zero": meaning.zero,
                "one": meaning.one,
                "unit": meaning.unit,
            })
        };
        let mut described = json!({
            "texel_meters": baked.report().texel * self.placement.scale,
            "highest_meters": baked.highest() * self.placement.scale,
            "maps": MAPS.iter().map(map).collect::<Vec<_>>(),
        });
        if let Some(name) = &part.name {
            described["part"] = name.as_str().into();
        }
        described
    }

    /// The parts in a list, or where all is in the same maps what that is.
    fn sidecar(&self) -> Value {
        let mut sidecar = match &self.parts[..] {
            [whole] if whole.get("part").is_none() => whole.clone(),
            parts => json!({ "parts": parts }),
        };
        sidecar["thallus"] = env!("CARGO_PKG_VERSION").into();
        sidecar["mesh"] = GLB.into();
        sidecar["size"] = self.size.into();
        sidecar["normal_green"] = match self.format.green {
            Green::Up => "up (OpenGL)",
            Green::Down => "down (DirectX)",
        }
        .into();
        sidecar
    }
}

/// The maps that a description names, as far as there is one.
fn maps_of(sidecar: &Path) -> Vec<String> {
    let told = fs::read(sidecar).ok();
    let told: Value = told
        .and_then(|told| serde_json::from_slice(&told).ok())
        .unwrap_or_default();
    let parts = told["parts"].as_array().into_iter().flatten();
    let maps = parts
        .chain([&told])
        .flat_map(|part| part["maps"].as_array());
    let names = maps.flatten().filter_map(|map| map["file"].as_str());
    let is_plain = |name: &&str| Path::new(name).file_name() == Some(OsStr::new(name));
    names.filter(is_plain).map(str::to_owned).collect()
}
