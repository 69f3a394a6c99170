//! Wavefront OBJ: `v`, `f` (and its old form `fo`); every other statement is passed over.
//!
//! We read it ourselves and not with `tobj` 4.0.5, although it takes only 2.6 µs and 264 bytes a
//! triangle where this takes 1.0 µs and 126 (`tests/load_cost.rs`), because of what it does to files
//! that exist. It refuses one for faults in what we never look at (texture coordinates, normals,
//! colours on some vertices, a bare `usemtl`, a byte that is not UTF-8 in a comment) and for comments
//! or `\` at the end of a line; it makes a triangle of `l 1 2 3`; it drops the first vertex after a
//! byte order mark and every `fo`; it repeats vertices that groups share; it divides by weights;
//! some texture indices make it panic; its errors name no line. Each statement would have to be
//! rewritten before `tobj` saw it, which is the parser below. Passes over the
//! text: positions first, so that a face may come before its vertices, then faces. Tolerated:
//! negative indices, `\` at a line's end, CRLF or lone CR, tabs, comments anywhere, rational
//! weights after the position, missing materials. Vertex colours after the position are read where textures are asked
//! for, as are materials (`mtl.rs`).
//! Free-form curves and surfaces are not evaluated.

use std::collections::HashMap;
use std::path::Path;

use memchr::memchr2;

use crate::color;
use crate::input::{quoted, without_mark};
use crate::substrate::texturing::{Corner, Of};
use crate::substrate::{Part, Soup, Texturing};

use super::Format::Obj;
use super::error::{LoadFault, Parsed};
use super::mtl::{self, Materials};
use super::polygon::{Corners, Triangulator};
use super::text::{integer, line_of, number, uncommented, used_are_finite, white};
use super::{counted, exclusive_index, no_triangles, udim};

/// Statements that make something other than flat faces, and what to call it.
const OTHER_GEOMETRY: [(&[u8], &str, &str); 7] = [
    (b"l", "line", "lines"),
    (b"p", "point element", "point elements"),
    (b"curv", "free-form curve", "free-form curves"),
    (b"surf", "free-form surface", "free-form surfaces"),
    (b"bzp", "Bezier patch", "Bezier patches"),
    (b"bsp", "B-spline patch", "B-spline patches"),
    (b"cdp", "Cardinal patch", "Cardinal patches"),
];

/// Reads an OBJ file's bytes.
pub(super) fn parse(
    bytes: &[u8],
    base: Option<&Path>,
    texturing: Option<&mut Texturing>,
) -> Parsed<Soup> {
    let text = without_mark(bytes);
    let positions = read_positions(text)?;
    let mut reader = FaceReader::new(text, positions);
    let attributes = texturing.is_some().then(|| Attributes::read(text, base));
    reader.attributes = attributes.filter(Attributes::has_some);
    for statement in Statements::new(text) {
        reader.statement(&statement)?;
    }
    if let (Some(out), Some(read)) = (texturing, reader.attributes.take()) {
        *out = read.texturing;
        let Materials {
            tiled, mut images, ..
        } = read.materials;
        udim::lay_out(&tiled, &mut images, out);
    }
    reader.finish()
}

/// Whether a library that the text names has something cut out.
pub(super) fn speaks_of_openings(bytes: &[u8], base: Option<&Path>) -> bool {
    let libraries = Statements::new(without_mark(bytes)).filter_map(|s| rest_of(&s, b"mtllib"));
    base.is_some_and(|base| mtl::speak_of_openings(libraries, base))
}

/// Whether the text has a statement that only an OBJ file would have.
pub(super) fn looks_like(bytes: &[u8]) -> bool {
    let text = without_mark(bytes);
    Statements::new(text).take(LINES_TO_SNIFF).any(|statement| {
        let mut tokens = statement.tokens();
        match tokens.next() {
            Some(b"v" | b"vn") => (0..3).all(|_| tokens.next().is_some_and(is_number)),
            Some(b"f" | b"l") => (0..2).all(|_| tokens.next().is_some_and(starts_with_index)),
            _ => false,
        }
    })
}

/// How far [`looks_like`] looks: exporters write long comments first.
const LINES_TO_SNIFF: usize = 10_000;

fn is_number(token: &[u8]) -> bool {
    number(token).is_some()
}

fn starts_with_index(token: &[u8]) -> bool {
    token
        .split(|&b| b == b'/')
        .next()
        .and_then(integer)
        .is_some()
}

/// One logical line: its bytes (line continuations included) and where it starts.
struct Statement<'a> {
    bytes: &'a [u8],
    start: usize,
}

impl<'a> Statement<'a> {
    /// Where a comment begins: at a `#` that is not in `1.#QNAN` or such.
    fn comment(&self) -> usize {
        let begins = |&at: &usize| !self.bytes[..at].ends_with(b"1.");
        let hash = self.bytes.iter().position(|&b| b == b'#');
        let Some(first) = hash else {
            return self.bytes.len();
        };
        let mut hashes = (first..self.bytes.len()).filter(|&at| self.bytes[at] == b'#');
        hashes.find(begins).unwrap_or(self.bytes.len())
    }

    /// The words up to a comment. A continuation is white space.
    fn tokens(&self) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        self.bytes[..self.comment()]
            .split(|b| b.is_ascii_whitespace() || *b == b'\\')
            .filter(|token| !token.is_empty())
    }
}

struct Statements<'a> {
    text: &'a [u8],
    at: usize,
}

impl<'a> Statements<'a> {
    fn new(text: &'a [u8]) -> Self {
        Self { text, at: 0 }
    }

    /// Where the physical line that starts at `from` ends, and where the next begins. LF, CRLF and CR alone may be
    /// mixed, as where a program puts a line on top of another's file.
    fn line_after(&self, from: usize) -> (usize, usize) {
        let rest = &self.text[from..];
        match memchr2(b'\n', b'\r', rest) {
            None => (self.text.len(), self.text.len()),
            Some(n) if rest[n..].starts_with(b"\r\n") => (from + n, from + n + 2),
            Some(n) => (from + n, from + n + 1),
        }
    }
}

impl<'a> Iterator for Statements<'a> {
    type Item = Statement<'a>;

    fn next(&mut self) -> Option<Statement<'a>> {
        let start = self.at;
        if start >= self.text.len() {
            return None;
        }
        let (mut end, mut next) = self.line_after(start);
        let mut line = start..end;
        let may_go_on = may_go_on(&self.text[line.clone()]);
        while may_go_on && next > end && continues(&self.text[line.clone()], &self.text[next..]) {
            line.start = next;
            (end, next) = self.line_after(next);
            line.end = end;
        }
        self.at = next;
        Some(Statement {
            bytes: &self.text[start..end],
            start,
        })
    }
}

/// Whether a statement may go on after its first line. A `\` that ends a name, as a folder's, does not say so.
fn may_go_on(first: &[u8]) -> bool {
    const NAMING: [&[u8]; 6] = [b"g", b"o", b"usemtl", b"mtllib", b"usemap", b"maplib"];
    if !is_open(first) {
        return false;
    }
    let keyword = first.trim_ascii_start();
    let keyword = keyword
        .split(u8::is_ascii_whitespace)
        .next()
        .unwrap_or_default();
    !NAMING.contains(&keyword)
}

/// Whether a line goes on in the text after it. A `\` that ends a comment does not say so, nor does one before
/// a line that begins with a word: numbers go on with numbers.
fn continues(line: &[u8], rest: &[u8]) -> bool {
    let next = rest.trim_ascii_start().first();
    is_open(line)
        && !line.contains(&b'#')
        && !next.is_some_and(|b| b.is_ascii_alphabetic() || *b == b'#')
}

/// Whether a line ends with `\`, but for blanks.
fn is_open(line: &[u8]) -> bool {
    line.trim_ascii_end().ends_with(b"\\")
}

/// Whether this is a `v` line: decided without tokenizing, as most lines are not.
fn is_vertex(statement: &[u8]) -> bool {
    matches!(statement.trim_ascii_start(), [b'v', space, ..] if space.is_ascii_whitespace() || *space == b'\\')
}

fn read_positions(text: &[u8]) -> Parsed<Vec<[f64; 3]>> {
    let count = Statements::new(text).filter(|s| is_vertex(s.bytes)).count();
    let mut positions = Vec::with_capacity(count);
    for statement in Statements::new(text).filter(|s| is_vertex(s.bytes)) {
        positions.push(read_position(text, &statement)?);
    }
    exclusive_index(positions.len(), Obj)?;
    Ok(positions)
}

fn read_position(text: &[u8], statement: &Statement) -> Parsed<[f64; 3]> {
    let place = || format!("line {}", line_of(text, statement.start));
    let mut tokens = statement.tokens().skip(1);
    let mut position = [0.0; 3];
    for coordinate in &mut position {
        let token = tokens.next().unwrap_or_default();
        *coordinate = number(token).ok_or_else(|| {
            LoadFault::malformed(
                Obj,
                place(),
                format!("a vertex needs three numbers, not {}", quoted(token)),
                "correct the line or export the file again",
            )
        })?;
    }
    Ok(position)
}

struct FaceReader<'a> {
    text: &'a [u8],
    soup: Soup,
    /// Vertices defined above the current line, for negative indices.
    vertices_above: usize,
    corners: Vec<u32>,
    triangulator: Triangulator,
    /// Where they are asked for.
    attributes: Option<Attributes>,
    two_cornered: usize,
    others: [usize; OTHER_GEOMETRY.len()],
}

impl<'a> FaceReader<'a> {
    fn new(text: &'a [u8], positions: Vec<[f64; 3]>) -> Self {
        // Exact for pure triangles; other polygons grow it.
        let faces = Statements::new(text).filter(|s| is_face(s.bytes)).count();
        Self {
            text,
            soup: Soup {
                positions,
                triangles: Vec::with_capacity(faces),
                notes: Vec::new(),
            },
            vertices_above: 0,
            corners: Vec::new(),
            triangulator: Triangulator::new(Obj),
            attributes: None,
            two_cornered: 0,
            others: [0; OTHER_GEOMETRY.len()],
        }
    }

    fn statement(&mut self, statement: &Statement) -> Parsed<()> {
        if is_vertex(statement.bytes) {
            self.vertices_above += 1;
            return Ok(());
        }
        if is_face(statement.bytes) {
            return self.face(statement);
        }
        if let Some(attributes) = &mut self.attributes {
            attributes.statement(statement);
        }
        let word = statement.bytes.trim_ascii_start();
        if word.first().is_some_and(|first| b"lpcsb".contains(first))
            && let Some(keyword) = statement.tokens().next()
            && let Some(kind) = OTHER_GEOMETRY
                .iter()
                .position(|(word, ..)| *word == keyword)
        {
            self.others[kind] += 1;
        }
        Ok(())
    }

    fn face(&mut self, statement: &Statement) -> Parsed<()> {
        let mut corners = std::mem::take(&mut self.corners);
        corners.clear();
        for token in statement.tokens().skip(1) {
            corners.push(self.corner(statement, token)?);
        }
        self.two_cornered += usize::from(corners.len() < 3);
        let Soup {
            positions,
            triangles,
            ..
        } = &mut self.soup;
        let before = triangles.len();
        let place = || format!("line {}", line_of(self.text, statement.start));
        self.triangulator
            .polygon(positions, &corners, triangles, place)?;
        if let Some(attributes) = &mut self.attributes {
            attributes.face(statement, &corners, &self.soup.triangles[before..]);
        }
        self.corners = corners;
        Ok(())
    }

    /// The position that a corner (`7`, `7/1`, `7/1/2`, `7//2`, `-1`) names.
    fn corner(&self, statement: &Statement, token: &[u8]) -> Parsed<u32> {
        let position = token.split(|&b| b == b'/').next().unwrap_or_default();
        let resolved = match integer(position) {
            None | Some(0) => None,
            Some(index) if index < 0 => usize::try_from(index.unsigned_abs())
                .ok()
                .and_then(|back| self.vertices_above.checked_sub(back)),
            Some(index) => usize::try_from(index - 1).ok(),
        };
        match resolved {
            Some(index) if index < self.soup.positions.len() => Ok(index as u32),
            _ if !position.iter().all(|b| b"+-0123456789".contains(b)) => {
                Err(self.no_number(statement, token))
            }
            _ => Err(self.no_such_vertex(statement, token)),
        }
    }

    fn place(&self, statement: &Statement) -> String {
        format!("line {}", line_of(self.text, statement.start))
    }

    #[cold]
    fn no_number(&self, statement: &Statement, token: &[u8]) -> LoadFault {
        LoadFault::malformed(
            Obj,
            self.place(statement),
            format!(
                "a face's corner is the whole number of a vertex, not {}",
                quoted(token)
            ),
            "correct the line or export the file again",
        )
    }

    #[cold]
    fn no_such_vertex(&self, statement: &Statement, token: &[u8]) -> LoadFault {
        LoadFault::malformed(
            Obj,
            self.place(statement),
            format!(
                "a face refers to vertex {}; there are {} (counted from 1)",
                quoted(token),
                self.soup.positions.len()
            ),
            "remove the face or export the file again",
        )
    }

    fn finish(self) -> Parsed<Soup> {
        let mut soup = self.soup;
        let mut passed_over = Vec::new();
        for (&count, (_, one, many)) in self.others.iter().zip(OTHER_GEOMETRY) {
            if count > 0 {
                passed_over.push(counted(count, one, many));
            }
        }
        if self.two_cornered > 0 {
            let (one, many) = ("face without three corners", "faces without three corners");
            passed_over.push(counted(self.two_cornered, one, many));
        }
        if soup.triangles.is_empty() {
            return Err(no_triangles(soup.positions.len(), &passed_over));
        }
        soup.notes.extend(
            passed_over
                .into_iter()
                .map(|what| format!("{what} ignored")),
        );
        soup.notes.extend(self.triangulator.notes());
        let text = self.text;
        used_are_finite(&mut soup, Obj, |vertex| {
            let mut vertices = Statements::new(text).filter(|s| is_vertex(s.bytes));
            let start = vertices.nth(vertex).map_or(0, |s| s.start);
            format!("line {}", line_of(text, start))
        })?;
        Ok(soup)
    }
}

/// Texture coordinates, normals, colours and materials of faces.
struct Attributes {
    places: Vec<Option<[f64; 2]>>,
    normals: Vec<Option<[f64; 3]>>,
    /// Of vertices, linear light; empty where none has any.
    colors: Vec<Option<[f32; 3]>>,
    /// Those defined above the current line, for negative indices.
    above: usize,
    normals_above: usize,
    /// The materials by name, and that of the next face.
    materials: Materials,
    of: Of,
    /// What the next faces are part of, by the keyword: of an object, groups and a material.
    names: [Vec<String>; NAMING_PARTS.len()],
    has_names: bool,
    parts: HashMap<(Vec<String>, Option<String>), u32>,
    texturing: Texturing,
}

const NAMING_PARTS: [&[u8]; 3] = [b"o", b"g", b"usemtl"];

impl Attributes {
    fn read(text: &[u8], base: Option<&Path>) -> Self {
        let place = |statement: Statement| {
            let [u] = numbers(&statement)?;
            // A curve's have no second.
            let v = statement.tokens().nth(2).map_or(Some(0.0), number)?;
            // Rows of OBJ's images are counted from below.
            Some([u, 1.0 - v])
        };
        let places = Statements::new(text).filter(|s| is_texcoord(s.bytes));
        let normals = Statements::new(text).filter(|s| is_normal(s.bytes));
        let mut texturing = Texturing::default();
        let libraries = Statements::new(text).filter_map(|s| rest_of(&s, b"mtllib"));
        Self {
            places: places.map(place).collect(),
            normals: normals.map(|s| numbers(&s)).collect(),
            colors: colors(text),
            above: 0,
            normals_above: 0,
            materials: mtl::read(libraries, base, &mut texturing),
            of: Of::default(),
            names: Default::default(),
            has_names: Statements::new(text).any(|s| names_a_part(&s).is_some()),
            parts: HashMap::new(),
            texturing,
        }
    }

    fn has_some(&self) -> bool {
        !self.places.is_empty() || !self.colors.is_empty() || self.has_names
    }

    /// Anything but a vertex or a face.
    fn statement(&mut self, statement: &Statement) {
        self.above += usize::from(is_texcoord(statement.bytes));
        self.normals_above += usize::from(is_normal(statement.bytes));
        let Some((keyword, name)) = names_a_part(statement) else {
            return;
        };
        if NAMING_PARTS[keyword] == b"usemtl" {
            self.of.material = self.materials.numbers.get(name).copied();
        }
        self.names[keyword] = all_names(NAMING_PARTS[keyword], name);
        self.of.part = None;
    }

    /// What the next faces are of.
    fn of(&mut self) -> Of {
        let [object, groups, material] = &self.names;
        if self.of.part.is_none() {
            let objects: Vec<String> = object.iter().chain(groups).cloned().collect();
            let material = material.first().cloned();
            let next = self.parts.len() as u32;
            let named = (objects.clone(), material.clone());
            let place = *self.parts.entry(named).or_insert(next);
            if place == next {
                self.texturing.parts.push(Part {
                    has_own_name: !objects.is_empty(),
                    objects,
                    material,
                    ..Part::default()
                });
            }
            self.of.part = Some(place);
        }
        self.of
    }

    /// Adds those of the triangles that a face was cut into. A face that comes to a vertex twice has the
    /// first's there.
    fn face(&mut self, statement: &Statement, corners: &[u32], triangles: &[[u32; 3]]) {
        let said = statement.tokens().skip(1).map(|token| self.corner(token));
        let said: Vec<_> = said.collect();
        let corners = Corners::new(corners);
        let of = self.of();
        let corner_of = |vertex: u32| {
            let corner = corners.at(vertex);
            let said = corner.map_or_else(Corner::default, |corner| said[corner]);
            let color = self.colors.get(vertex as usize).copied().flatten();
            Corner {
                colors: [color, None],
                ..said
            }
        };
        for triangle in triangles {
            self.texturing.push(triangle.map(corner_of), of);
        }
    }

    /// What a corner (`7/1`, `7/1/2`, `7//2`, `-1/-1`) names.
    fn corner(&self, token: &[u8]) -> Corner {
        let uv = named(token, 1, self.above);
        let normal = named(token, 2, self.normals_above);
        Corner {
            uvs: [uv.and_then(|at| *self.places.get(at)?), None],
            normal: normal.and_then(|at| *self.normals.get(at)?),
            ..Corner::default()
        }
    }
}

/// Which of the keywords that name parts a statement has, and the name.
fn names_a_part<'a>(statement: &Statement<'a>) -> Option<(usize, &'a [u8])> {
    let first = statement.bytes.trim_ascii_start().first()?;
    if !b"ogu".contains(first) {
        return None;
    }
    let mut all = NAMING_PARTS.into_iter().enumerate();
    all.find_map(|(keyword, word)| Some((keyword, rest_of(statement, word)?)))
}

/// A name and, of groups, which may be several, each by itself.
fn all_names(keyword: &[u8], name: &[u8]) -> Vec<String> {
    let whole = String::from_utf8_lossy(name).into_owned();
    let words = whole.split_ascii_whitespace().map(str::to_owned);
    let words = words.filter(|word| keyword == b"g" && *word != whole);
    let words: Vec<String> = words.collect();
    let whole = Some(whole).filter(|name| !name.is_empty());
    whole.into_iter().chain(words).collect()
}

/// What stands after a keyword, up to a comment or the end of the line.
fn rest_of<'a>(statement: &Statement<'a>, keyword: &[u8]) -> Option<&'a [u8]> {
    let rest = statement.bytes.trim_ascii_start().strip_prefix(keyword)?;
    let rest = rest
        .first()
        .is_some_and(u8::is_ascii_whitespace)
        .then_some(rest)?;
    Some(uncommented(rest).trim_ascii())
}

/// Colours of vertices (`v x y z r g b`), linear light; none where no vertex has one.
fn colors(text: &[u8]) -> Vec<Option<[f32; 3]>> {
    let vertices = Statements::new(text).filter(|s| is_vertex(s.bytes));
    let said = vertices.map(|s| numbers::<6>(&s).map(|[_, _, _, r, g, b]| [r, g, b]));
    let said: Vec<Option<[f64; 3]>> = said.collect();
    let most = white(said.iter().flatten().flatten().copied());
    let light = |color: &[f64; 3]| color.map(|x| color::decode_any(x / most));
    let last = said.iter().rposition(Option::is_some);
    let said = said.iter().take(last.map_or(0, |last| last + 1));
    said.map(|color| color.as_ref().map(light)).collect()
}

/// The number, from 0, that a corner names in this part of it, if it does.
fn named(token: &[u8], part: usize, above: usize) -> Option<usize> {
    let index = integer(token.split(|&b| b == b'/').nth(part)?)?;
    let back = usize::try_from(index.unsigned_abs()).ok()?;
    match index {
        ..0 => above.checked_sub(back),
        _ => back.checked_sub(1),
    }
}

/// The first numbers of a statement.
fn numbers<const N: usize>(statement: &Statement) -> Option<[f64; N]> {
    let mut tokens = statement.tokens().skip(1);
    let mut numbers = [0.0; N];
    for out in &mut numbers {
        *out = number(tokens.next()?)?;
    }
    Some(numbers)
}

/// Whether this is a `vt` line.
fn is_texcoord(statement: &[u8]) -> bool {
    matches!(statement.trim_ascii_start(), [b'v', b't', space, ..] if space.is_ascii_whitespace() || *space == b'\\')
}

/// Whether this is a `vn` line.
fn is_normal(statement: &[u8]) -> bool {
    matches!(statement.trim_ascii_start(), [b'v', b'n', space, ..] if space.is_ascii_whitespace() || *space == b'\\')
}

fn is_face(statement: &[u8]) -> bool {
    match statement.trim_ascii_start() {
        [b'f', b'o', space, ..] | [b'f', space, ..] => {
            space.is_ascii_whitespace() || *space == b'\\'
        }
        _ => false,
    }
}
