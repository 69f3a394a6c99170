//! Material libraries of Wavefront OBJ: the colour and the texture of each material and, as Blender and others write
//! them, its roughness, metal and normal map.
//!
//! Read here and not with `tobj`, which refuses a whole library for one word that is not its number, takes the options
//! before a file's name for a part of it, and knows no normal maps. A fault here is a note, and never keeps lichen from
//! growing. Where there is a texture that can be read, `Kd` is passed over, for programs write any colour beside one.

use std::collections::{HashMap, HashSet};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use crate::image::Image;
use crate::input::{self, without_mark};
use crate::substrate::{Alpha, Material, Texture, Texturing, Wrap};

use super::encoded_image;
use super::text::{number, uncommented};
use super::udim::{Tiled, udim_mark};

/// Faults that are told; of more only that there are.
const MOST_NOTES: usize = 12;

/// Reads libraries of these names: materials and their images are added, and their numbers are told by name. Of two
/// of one name the first counts. `base` is the folder in which they lie; without it none is read, which is a note.
pub(super) fn read<'a>(
    names: impl Iterator<Item = &'a [u8]>,
    base: Option<&Path>,
    out: &mut Texturing,
) -> Materials {
    let mut library = Library {
        out,
        numbers: HashMap::new(),
        images: Images::default(),
        colored: HashMap::new(),
        cut_out: Vec::new(),
        tiled: Vec::new(),
    };
    let mut names = names.peekable();
    let Some(base) = base else {
        if names.peek().is_some() {
            let note = "material libraries not read: there is no folder to look for them in";
            library.out.notes.push(note.to_owned());
        }
        return library.materials();
    };
    let mut read = HashSet::new();
    for file in names.flat_map(|name| files(base, name)) {
        if read.insert(file.clone()) {
            library.add(&file);
        }
    }
    library.cut_out();
    library.materials()
}

/// Whether any of the libraries of these names has a word of what is cut out.
pub(super) fn speak_of_openings<'a>(
    mut names: impl Iterator<Item = &'a [u8]>,
    base: &Path,
) -> bool {
    let speaks = |file: &PathBuf| {
        let text = input::regular_bytes(file).unwrap_or_default();
        memchr::memmem::find(&text, b"map_d").is_some()
    };
    let mut seen = HashSet::new();
    names.any(|name| seen.insert(name) && files(base, name).iter().any(speaks))
}

/// What libraries say.
pub(super) struct Materials {
    /// Places among the materials, by name.
    pub(super) numbers: HashMap<Vec<u8>, u32>,
    /// Textures that wait for the faces.
    pub(super) tiled: Vec<Tiled>,
    pub(super) images: Images,
}

/// What an image is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Slot {
    Color,
    Normal,
    /// Said to be a height: programs name normal maps so too, Blender among them.
    Bump,
}

/// Images that libraries name, each read and looked at once.
#[derive(Default)]
pub(super) struct Images {
    /// Their places; none for one that cannot be read.
    places: HashMap<PathBuf, Option<usize>>,
    /// Of those that may be heights, whether they are normal maps.
    upright: HashMap<usize, bool>,
}

impl Images {
    /// The place of an image that a library in this folder names. What cannot be read is a note.
    pub(super) fn read(
        &mut self,
        (folder, name): (&Path, &[u8]),
        out: &mut Texturing,
    ) -> Option<usize> {
        let file = found(folder, name);
        if let Some(known) = self.places.get(&file) {
            return *known;
        }
        let bytes = input::regular_bytes(&file).map_err(|e| e.to_string());
        let place = match bytes.and_then(encoded_image) {
            Ok(bytes) => {
                out.images.push(bytes);
                out.image_files.push(file.clone());
                Some(out.images.len() - 1)
            }
            Err(problem) => {
                let file = file.display();
                note(format!("the image {file} is passed over: {problem}"), out);
                None
            }
        };
        self.places.insert(file, place);
        place
    }

    /// Makes a texture one of a material's, if it is what it is said to be.
    pub(super) fn put(&mut self, slot: Slot, texture: Texture, number: usize, out: &mut Texturing) {
        let bytes = &out.images[texture.image];
        let is_upright = || is_normal_map(bytes);
        let is_height = slot == Slot::Bump
            && !*{ self.upright.entry(texture.image) }.or_insert_with(is_upright);
        let material = &mut out.materials[number];
        match slot {
            Slot::Color => {
                material.base_color = [1.0; 3];
                material.base_color_texture = Some(texture);
            }
            Slot::Normal => material.normal_texture = Some(texture),
            Slot::Bump if is_height => note(
                "a map_Bump is passed over: it is a height and no normal map; bake it into one, and name that as norm"
                    .to_owned(),
                out,
            ),
            Slot::Bump => {
                material.normal_texture.get_or_insert(texture);
            }
        }
    }
}

/// Tells what is not told yet; of too much only that there is more.
pub(super) fn note(note: String, out: &mut Texturing) {
    match out.notes.len() {
        ..MOST_NOTES if !out.notes.contains(&note) => out.notes.push(note),
        MOST_NOTES => out.notes.push("and so are others".into()),
        _ => {}
    }
}

/// Whether most of an image stands straight up, read as a normal map. One that is damaged is told of by whoever shows
/// it.
fn is_normal_map(bytes: &[u8]) -> bool {
    Image::decode(bytes).is_ok_and(|image| {
        let [red, green, blue] = image.mean().to_array();
        [red, green].iter().all(|x| (0.35..0.65).contains(x)) && blue > 0.75
    })
}

/// The files that a statement names: one, with spaces in its name, or several.
fn files(base: &Path, names: &[u8]) -> Vec<PathBuf> {
    let whole = found(base, names);
    let parts = words(names).map(|name| found(base, name));
    let parts: Vec<PathBuf> = parts.collect();
    match !whole.is_file() && parts.iter().any(|file| file.is_file()) {
        true => parts,
        false => vec![whole],
    }
}

/// A file by the name that another gives it: where it says, else beside that other, as files are moved together.
fn found(folder: &Path, name: &[u8]) -> PathBuf {
    let name = String::from_utf8_lossy(name);
    let as_said = folder.join(&*name);
    let with_slashes = name.replace('\\', "/");
    let last = Path::new(&with_slashes).file_name().map(OsStr::to_owned);
    let beside = last.map(|last| folder.join(last));
    let others = [Some(folder.join(&with_slashes)), beside];
    let is_there = |file: &PathBuf| !as_said.is_file() && file.is_file();
    others
        .into_iter()
        .flatten()
        .find(is_there)
        .unwrap_or(as_said)
}

fn words(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    let words = text.split(u8::is_ascii_whitespace);
    words.filter(|word| !word.is_empty())
}

/// The first word, and what follows it.
fn first_word(text: &[u8]) -> (&[u8], &[u8]) {
    let text = text.trim_ascii();
    let end = text.iter().position(u8::is_ascii_whitespace);
    let (word, rest) = text.split_at(end.unwrap_or(text.len()));
    (word, rest.trim_ascii())
}

struct Library<'a> {
    out: &'a mut Texturing,
    numbers: HashMap<Vec<u8>, u32>,
    images: Images,
    /// What the colour of a material is read from.
    colored: HashMap<usize, PathBuf>,
    /// What a material is cut out by.
    cut_out: Vec<(usize, PathBuf)>,
    tiled: Vec<Tiled>,
}

impl Library<'_> {
    fn add(&mut self, file: &Path) {
        let text = match input::regular_bytes(file) {
            Ok(text) => text,
            Err(e) => {
                let note = format!("the materials in {} cannot be read: {e}", file.display());
                return self.note(note);
            }
        };
        let text = without_mark(&text);
        let folder = file.parent().unwrap_or(Path::new(""));
        let mut material = None;
        for line in text.split(|b| b"\r\n".contains(b)) {
            match (first_word(uncommented(line)), material) {
                ((b"newmtl", name), _) => material = self.begin(name),
                ((word, rest), Some(number)) => self.say(number, word, rest, folder),
                _ => {}
            }
        }
    }

    fn note(&mut self, text: String) {
        note(text, self.out);
    }

    /// Begins a material, if there is none of its name yet.
    fn begin(&mut self, name: &[u8]) -> Option<usize> {
        if self.numbers.contains_key(name) {
            return None;
        }
        let number = self.out.materials.len();
        self.numbers.insert(name.to_owned(), number as u32);
        self.out.materials.push(Material::default());
        Some(number)
    }

    fn materials(self) -> Materials {
        Materials {
            numbers: self.numbers,
            tiled: self.tiled,
            images: self.images,
        }
    }

    /// Has materials cut out by the alpha of their colour's image, where that is named for it.
    fn cut_out(&mut self) {
        for (number, file) in std::mem::take(&mut self.cut_out) {
            if self.colored.get(&number) != Some(&file) {
                self.note(format!(
                    "the image {} is passed over: opacity is read from the alpha of the colour's own image (map_Kd)",
                    file.display()
                ));
                self.out.materials[number].unread_opacity = Some(image_of(&file));
                continue;
            }
            let is_tiled = self.tiled.iter().any(|tiled| tiled.material == number);
            let material = &mut self.out.materials[number];
            let is_unread = material.base_color_texture.is_none() && !is_tiled;
            material.unread_opacity = is_unread.then(|| image_of(&file));
            material.alpha = Alpha::Mask { cutoff: 0.5 };
            material.is_double_sided = true;
        }
    }

    /// Takes what a line says of a material.
    fn say(&mut self, number: usize, word: &[u8], rest: &[u8], folder: &Path) {
        match word {
            b"map_Kd" => return self.texture(number, Slot::Color, (folder, rest)),
            b"norm" => return self.texture(number, Slot::Normal, (folder, rest)),
            b"map_Bump" | b"map_bump" | b"bump" => {
                return self.texture(number, Slot::Bump, (folder, rest));
            }
            b"map_d" => {
                let file = found(folder, Said::read(rest).file);
                return self.cut_out.push((number, file));
            }
            _ => {}
        }
        let material = &mut self.out.materials[number];
        let mut shares = words(rest).map_while(share);
        let first = shares.next();
        match (word, first) {
            (b"Kd", Some(red)) => {
                let [green, blue] = [(); 2].map(|()| shares.next().unwrap_or(red));
                material.bare_color = [red, green, blue];
                if material.base_color_texture.is_none() {
                    material.base_color = material.bare_color;
                }
            }
            (b"Pr", Some(rough)) => material.roughness = rough,
            (b"Pm", Some(metal)) => material.metallic = metal,
            _ => {}
        }
    }

    /// Takes what a line says of a texture, in a library in this folder.
    fn texture(&mut self, number: usize, slot: Slot, (folder, text): (&Path, &[u8])) {
        let said = Said::read(text);
        let file = found(folder, said.file);
        if slot == Slot::Color {
            self.colored.insert(number, file.clone());
        }
        if udim_mark(said.file).is_some() {
            return self.tiled.push(Tiled {
                material: number,
                slot,
                strength: said.strength,
                folder: folder.to_owned(),
                name: said.file.to_owned(),
            });
        }
        let image = self.images.read((folder, said.file), self.out);
        let Some(image) = image else { return };
        let texture = Texture {
            image,
            is_in_second: false,
            strength: said.strength,
            transform: said.transform(),
            wrap: said.wrap,
        };
        self.images.put(slot, texture, number, self.out);
    }
}

fn image_of(file: &Path) -> String {
    format!("the image {}", file.display())
}

/// A number from 0 to 1, or the nearest of these.
fn share(word: &[u8]) -> Option<f32> {
    let number = number(word).filter(|x| x.is_finite())?;
    Some(number.clamp(0.0, 1.0) as f32)
}

/// What a statement says of a texture: its file, after options.
struct Said<'a> {
    file: &'a [u8],
    /// `-bm`.
    strength: f32,
    /// `-s` and `-o`, along the image's rows and, from below, along its columns.
    scale: [f64; 2],
    offset: [f64; 2],
    /// `-clamp`.
    wrap: [Wrap; 2],
}

impl<'a> Said<'a> {
    fn read(text: &'a [u8]) -> Self {
        let mut said = Self {
            file: text.trim_ascii(),
            strength: 1.0,
            scale: [1.0; 2],
            offset: [0.0; 2],
            wrap: [Wrap::Repeat; 2],
        };
        while let (option @ [b'-', _, ..], rest) = first_word(said.file) {
            said.file = said.option(option, rest);
        }
        said
    }

    /// Takes an option; what follows it.
    fn option(&mut self, option: &[u8], rest: &'a [u8]) -> &'a [u8] {
        let most = match option {
            b"-s" | b"-o" | b"-t" => 3,
            b"-mm" => 2,
            b"-bm" => 1,
            b"-clamp" => {
                let (word, rest) = first_word(rest);
                let is_on = word.eq_ignore_ascii_case(b"on");
                self.wrap = [if is_on { Wrap::Clamp } else { Wrap::Repeat }; 2];
                return rest;
            }
            _ => return first_word(rest).1,
        };
        let mut rest = rest;
        let mut numbers = Vec::new();
        while let (Some(x), true) = (number(first_word(rest).0), numbers.len() < most) {
            numbers.push(if x.is_finite() { x } else { 0.0 });
            rest = first_word(rest).1;
        }
        match (option, &numbers[..]) {
            (b"-s", [u, others @ ..]) => self.scale = [*u, others.first().copied().unwrap_or(1.0)],
            (b"-o", [u, others @ ..]) => self.offset = [*u, others.first().copied().unwrap_or(0.0)],
            (b"-bm", [strength]) if (*strength as f32).is_finite() => {
                self.strength = *strength as f32
            }
            _ => {}
        }
        rest
    }

    /// For coordinates that are counted from above.
    fn transform(&self) -> [[f64; 3]; 2] {
        let ([su, sv], [ou, ov]) = (self.scale, self.offset);
        [[su, 0.0, ou], [0.0, sv, 1.0 - sv - ov]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_before_the_file_are_taken() {
        let said = Said::read(b" -colorspace sRGB -blendu on -s 2 3 1 -o 0.25 a stone 01.png ");
        assert_eq!(said.file, b"a stone 01.png");
        // The image's lower left corner is at (0.25, 0), three from below to above.
        assert_eq!(said.transform(), [[2.0, 0.0, 0.25], [0.0, 3.0, -2.0]]);
        let said = Said::read(b"-bm 0.5 -mm 0 1 -t 1 -clamp off n.png");
        assert_eq!((said.file, said.strength), (&b"n.png"[..], 0.5));
        assert_eq!(said.transform(), [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        assert_eq!(said.wrap, [Wrap::Repeat; 2]);
        assert_eq!(Said::read(b"-clamp on n.png").wrap, [Wrap::Clamp; 2]);
        for empty in [&b""[..], b"-s", b"-s 1 2 3", b"-clamp", b"-bm x"] {
            assert!(Said::read(empty).file.len() < 2, "{empty:?}");
        }
    }
}
