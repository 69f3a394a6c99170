//! PLY (Turk 1994): ASCII and binary of either byte order, properties of any name and type.
//!
//! We read it ourselves and not with `serde-ply`, which wants every element's properties declared
//! as a type before it reads, where a file's own header decides here. Faces may be polygons; `tristrips` (with −1 to
//! restart) are unrolled. Other elements and properties are passed over, in any order; faces may stand before their
//! vertices. Positions declared `float` are read as such, even in ASCII, so that they are what their writer had.

use crate::color;
use crate::input::quoted;
use crate::ply::{Element, Encoding, Header, HeaderFault, Kind, Scalar, read_header};
use crate::substrate::soup::is_representable;
use crate::substrate::texturing::{Corner, Of};
use crate::substrate::{Soup, Texturing};

use super::Format::Ply;
use super::error::{LoadFault, Parsed};
use super::ply_body::{Ascii, Binary, Body};
use super::polygon::{Corners as FaceCorners, Triangulator};
use super::text::{used_are_finite, white};
use super::{counted, exclusive_index, no_triangles};

/// Reads a PLY file's bytes.
pub(super) fn parse(bytes: &[u8], texturing: Option<&mut Texturing>) -> Parsed<Soup> {
    let mut body = bytes;
    let header = read_header(&mut body).map_err(in_header)?;
    let at = bytes.len() - body.len();
    match header.encoding {
        Encoding::Ascii => read(&header, Ascii::new(bytes, at), texturing),
        Encoding::LittleEndian => read(&header, Binary::<false> { bytes, at }, texturing),
        Encoding::BigEndian => read(&header, Binary::<true> { bytes, at }, texturing),
    }
}

fn in_header(fault: HeaderFault) -> LoadFault {
    let cure = "correct the header or export the file again";
    LoadFault::malformed(Ply, format!("line {}", fault.line), fault.problem, cure)
}

fn read<B: Body>(header: &Header, body: B, texturing: Option<&mut Texturing>) -> Parsed<Soup> {
    let mut reader = Reader::new(header, body);
    let has_some = texturing.is_some() && header.elements.iter().any(Attributes::are_in);
    reader.attributes = has_some.then(Attributes::default);
    let (soup, attributes) = reader.read()?;
    if let (Some(out), Some(read)) = (texturing, attributes) {
        *out = read.texturing;
    }
    Ok(soup)
}

/// Texture coordinates, of vertices (`s t`, `u v`, `texture_u texture_v`) or of the corners of faces
/// (a list `texcoord`), and colours of vertices.
#[derive(Default)]
struct Attributes {
    of_vertices: Vec<[f64; 2]>,
    /// Linear light.
    colors: Vec<[f32; 3]>,
    /// Of the current face's corners, one after the other.
    of_corners: Vec<f64>,
    texturing: Texturing,
}

/// Names of a vertex's texture coordinates.
const TEXCOORDS: [[&[u8]; 2]; 3] = [[b"s", b"t"], [b"u", b"v"], [b"texture_u", b"texture_v"]];

/// Names of a vertex's colour, sRGB: fractions to 1 or to 255, `ushort` to 65,535, other whole numbers to 255.
const COLORS: [[&[u8]; 3]; 3] = [
    [b"red", b"green", b"blue"],
    [b"diffuse_red", b"diffuse_green", b"diffuse_blue"],
    [b"r", b"g", b"b"],
];

/// Where an element has single properties of these names, those of the first set that it has whole.
fn places<const N: usize>(element: &Element, names: &[[&[u8]; N]]) -> Option<[usize; N]> {
    let is_single = |&at: &usize| matches!(element.properties[at].kind, Kind::One(_));
    names.iter().find_map(|names| {
        let all = names.map(|name| element.position(name).filter(is_single));
        all.iter()
            .all(Option::is_some)
            .then(|| all.map(Option::unwrap_or_default))
    })
}

/// The number of the list that holds vertex indices: by name, or the only list of integers.
fn index_list(element: &Element) -> Option<usize> {
    let is_index_list = |&at: &usize| matches!(element.properties[at].kind, Kind::List { item, .. } if item.is_integer());
    let named = element
        .position(b"vertex_indices")
        .or_else(|| element.position(b"vertex_index"));
    named.filter(is_index_list).or_else(|| {
        let mut lists = (0..element.properties.len()).filter(is_index_list);
        lists.next().filter(|_| lists.next().is_none())
    })
}

/// Linear light of vertices' colours, written as numbers of this kind.
fn light(kind: Kind, written: &[[f64; 3]]) -> Vec<[f32; 3]> {
    let most = match kind {
        Kind::One(Scalar::F32 | Scalar::F64) => white(written.as_flattened().iter().copied()),
        Kind::One(Scalar::U16) => 65_535.0,
        _ => 255.0,
    };
    let light = |color: &[f64; 3]| color.map(|number| color::decode_any(number / most));
    written.iter().map(light).collect()
}

impl Attributes {
    /// Whether an element has any.
    fn are_in(element: &Element) -> bool {
        match element.name.as_slice() {
            b"vertex" => {
                places(element, &TEXCOORDS).is_some() || places(element, &COLORS).is_some()
            }
            _ => element.position(b"texcoord").is_some(),
        }
    }

    /// Adds those of the triangles that a face was cut into.
    fn face(&mut self, corners: &[u32], triangles: &[[u32; 3]]) {
        let of_corners = &self.of_corners;
        // Some write a third, as of a texture in space.
        let width = match of_corners.len() == 3 * corners.len() {
            true => 3,
            false => 2,
        };
        let corners = FaceCorners::new(corners);
        let place = |vertex: u32| {
            let corner = corners.at(vertex);
            let of_corner = corner.and_then(|at| of_corners.get(width * at..width * at + 2));
            let of_vertex = || self.of_vertices.get(vertex as usize).copied();
            let [u, v] = of_corner.map(|uv| [uv[0], uv[1]]).or_else(of_vertex)?;
            // Rows of images are counted from below.
            Some([u, 1.0 - v])
        };
        let corner = |vertex: u32| Corner {
            uvs: [place(vertex), None],
            colors: [self.colors.get(vertex as usize).copied(), None],
            normal: None,
        };
        for triangle in triangles {
            self.texturing.push(triangle.map(corner), Of::default());
        }
    }
}

struct Reader<'a, B> {
    header: &'a Header,
    body: B,
    soup: Soup,
    triangulator: Triangulator,
    /// Where they are asked for.
    attributes: Option<Attributes>,
    /// Lists of fewer than three corners.
    too_short: usize,
    /// Elements that hold points or edges, for the message when there is nothing else.
    others: Vec<String>,
    /// Vertices without a finite position, and where they end.
    unfit: Vec<(usize, usize)>,
}

/// One row's list of vertex indices; −1 is kept for strips.
type Corners = Vec<i64>;

impl<'a, B: Body> Reader<'a, B> {
    fn new(header: &'a Header, body: B) -> Self {
        let soup = Soup::default();
        let triangulator = Triangulator::new(Ply);
        Self {
            header,
            body,
            soup,
            triangulator,
            attributes: None,
            too_short: 0,
            others: Vec::new(),
            unfit: Vec::new(),
        }
    }

    fn read(mut self) -> Parsed<(Soup, Option<Attributes>)> {
        let rest = self.elements().map_err(|fault| {
            let overlong = self.overlong(&self.body);
            overlong.unwrap_or(fault)
        })?;
        let attributes = self.attributes.take();
        Ok((self.finish(rest)?, attributes))
    }

    /// Reads all elements. What is left, in words.
    fn elements(&mut self) -> Parsed<Option<String>> {
        let mut before_vertices = Vec::new();
        let mut have_vertices = false;
        let header = self.header;
        for element in &header.elements {
            self.check_room(element)?;
            match (element.name.as_slice(), have_vertices) {
                (b"vertex", true) => {
                    return Err(self.fault("there are two vertex elements".into()));
                }
                (b"vertex", false) => {
                    self.vertices(element)?;
                    have_vertices = true;
                }
                (b"face" | b"tristrips", true) => self.faces(element)?,
                (b"face" | b"tristrips", false) => {
                    before_vertices.push((element, self.body.clone()));
                    self.pass_over(element)?;
                }
                _ => self.pass_over(element)?,
            }
        }
        let end = self.body.clone();
        for (element, body) in before_vertices {
            self.body = body;
            self.faces(element)?;
        }
        let rest = end.rest();
        match self.overlong(&end).filter(|_| rest.is_some()) {
            Some(fault) => Err(fault),
            None => Ok(rest),
        }
    }

    /// The fault of a file with more in a line than its header declares.
    fn overlong(&self, body: &B) -> Option<LoadFault> {
        let elements = self.header.elements.iter();
        let rows = elements.filter(|element| !element.properties.is_empty());
        let rows = rows.map(|element| element.count);
        let at = body.overlong(rows.fold(0, usize::saturating_add))?;
        let problem = "there is more in this line than the header declares";
        let cure = "declare it in the header or export the file again";
        Some(LoadFault::malformed(Ply, body.place_of(at), problem, cure))
    }

    /// Holds the header's count against the bytes that are there.
    fn check_room(&self, element: &Element) -> Parsed<()> {
        let least = element.least_bytes(self.header.encoding);
        // The last ASCII number needs no separator.
        let room = (self.body.left() + 1)
            .checked_div(least)
            .unwrap_or(usize::MAX);
        if element.count <= room {
            return Ok(());
        }
        let (name, count) = (quoted(&element.name), element.count);
        let problem = format!("the header promises {count} rows of {name}, at most {room} follow");
        Err(LoadFault::malformed(
            Ply,
            self.body.place(),
            problem,
            "it was cut short: export or copy it again",
        ))
    }

    fn vertices(&mut self, element: &Element) -> Parsed<()> {
        exclusive_index(element.count, Ply)?;
        let mut axes = [0; 3];
        for (axis, name) in axes.iter_mut().zip([b"x", b"y", b"z"]) {
            let capital = name.to_ascii_uppercase();
            let position = element
                .position(name)
                .or_else(|| element.position(&capital));
            *axis = position.ok_or_else(|| {
                self.fault(format!("the vertices have no property {}", quoted(name)))
            })?;
            if let Kind::List { .. } = element.properties[*axis].kind {
                let problem = format!("the vertices' property {} is a list", quoted(name));
                return Err(self.fault(problem));
            }
        }
        let asked = self.attributes.is_some();
        let texcoords = places(element, &TEXCOORDS).filter(|_| asked);
        let colors = places(element, &COLORS).filter(|_| asked);
        let mut wanted = vec![false; element.properties.len()];
        let others = texcoords.iter().flatten().chain(colors.iter().flatten());
        axes.iter().chain(others).for_each(|&at| wanted[at] = true);
        let mut row = vec![0.0; element.properties.len()];
        self.soup.positions.reserve_exact(element.count);
        let mut written = Vec::new();
        for vertex in 0..element.count {
            self.row(element, &wanted, &mut row)
                .ok_or_else(|| self.broken("vertex", vertex))?;
            let position = axes.map(|at| row[at]);
            if !is_representable(position) {
                self.unfit.push((vertex, self.body.at()));
            }
            self.soup.positions.push(position);
            if let Some(attributes) = &mut self.attributes {
                let texcoords = texcoords.map(|places| places.map(|at| row[at]));
                attributes.of_vertices.extend(texcoords);
                written.extend(colors.map(|places| places.map(|at| row[at])));
            }
        }
        if let (Some(attributes), Some([red, ..])) = (&mut self.attributes, colors) {
            attributes.colors = light(element.properties[red].kind, &written);
        }
        Ok(())
    }

    /// Reads those of an element's next numbers that are wanted, each into its own place.
    fn row(&mut self, element: &Element, wanted: &[bool], row: &mut [f64]) -> Option<()> {
        for ((property, wanted), value) in element.properties.iter().zip(wanted).zip(row) {
            match property.kind {
                Kind::One(scalar) if *wanted => *value = self.body.real(scalar)?,
                kind => self.skip(kind)?,
            }
        }
        self.body.end_row();
        Some(())
    }

    fn faces(&mut self, element: &Element) -> Parsed<()> {
        let list = index_list(element).ok_or_else(|| {
            let name = quoted(&element.name);
            self.fault(format!(
                "element {name} has no list vertex_indices of whole numbers"
            ))
        })?;
        let texture_list = element
            .position(b"texcoord")
            .filter(|_| self.attributes.is_some());
        let strips = element.name == b"tristrips";
        if !strips {
            self.soup.triangles.reserve_exact(element.count);
        }
        if let Some(attributes) = &mut self.attributes {
            // Those of another element's last face.
            attributes.of_corners.clear();
        }
        let mut raw = Corners::new();
        let mut corners = Vec::new();
        for row in 0..element.count {
            for (at, property) in element.properties.iter().enumerate() {
                let read = match property.kind {
                    Kind::List { count, item } if at == list => {
                        self.index_list(count, item, &mut raw)
                    }
                    Kind::List { count, item } if Some(at) == texture_list => {
                        self.texture_list(count, item)
                    }
                    kind => self.skip(kind),
                };
                read.ok_or_else(|| self.broken("face", row))?;
            }
            self.body.end_row();
            if strips {
                self.strips(&raw, row, &mut corners)?;
            } else {
                self.polygon(&raw, row, &mut corners)?;
            }
        }
        Ok(())
    }

    fn index_list(&mut self, count: Scalar, item: Scalar, out: &mut Corners) -> Option<()> {
        out.clear();
        let length = usize::try_from(self.body.integer(count)?).ok()?;
        if length > self.body.most(item) {
            return None;
        }
        self.body.integers(item, length, out)
    }

    fn texture_list(&mut self, count: Scalar, item: Scalar) -> Option<()> {
        let length = usize::try_from(self.body.integer(count)?).ok()?;
        if length > self.body.most(item) {
            return None;
        }
        let mut read = Vec::with_capacity(length);
        for _ in 0..length {
            read.push(self.body.real(item)?);
        }
        if let Some(attributes) = &mut self.attributes {
            attributes.of_corners = read;
        }
        Some(())
    }

    fn polygon(&mut self, raw: &Corners, row: usize, corners: &mut Vec<u32>) -> Parsed<()> {
        corners.clear();
        for &index in raw {
            corners.push(self.checked(index, row)?);
        }
        self.too_short += usize::from(corners.len() < 3);
        let Soup {
            positions,
            triangles,
            ..
        } = &mut self.soup;
        let before = triangles.len();
        let place = || format!("face {row} ({})", self.body.place());
        self.triangulator
            .polygon(positions, corners, triangles, place)?;
        if let Some(attributes) = &mut self.attributes {
            attributes.face(corners, &self.soup.triangles[before..]);
        }
        Ok(())
    }

    /// Unrolls strips; stitching triangles (two equal corners) are left out.
    fn strips(&mut self, raw: &Corners, row: usize, corners: &mut Vec<u32>) -> Parsed<()> {
        for strip in raw.split(|&index| index == -1) {
            corners.clear();
            for &index in strip {
                corners.push(self.checked(index, row)?);
            }
            for (i, window) in corners.windows(3).enumerate() {
                let [a, b, c] = [window[0], window[1], window[2]];
                if a != b && b != c && c != a {
                    let triangle = if i % 2 == 0 { [a, b, c] } else { [a, c, b] };
                    self.soup.triangles.push(triangle);
                    if let Some(attributes) = &mut self.attributes {
                        attributes.of_corners.clear();
                        attributes.face(&[], &[triangle]);
                    }
                }
            }
        }
        Ok(())
    }

    #[inline]
    fn checked(&self, index: i64, row: usize) -> Parsed<u32> {
        match u32::try_from(index) {
            Ok(vertex) if (vertex as usize) < self.soup.positions.len() => Ok(vertex),
            _ => Err(self.no_vertex(index, row)),
        }
    }

    #[cold]
    fn no_vertex(&self, index: i64, row: usize) -> LoadFault {
        let count = self.soup.positions.len();
        LoadFault::malformed(
            Ply,
            format!("face {row} ({})", self.body.place()),
            format!("vertex {index} is named, but there are {count} (counted from 0)"),
            "remove the face or export the file again",
        )
    }

    fn pass_over(&mut self, element: &Element) -> Parsed<()> {
        if element.count > 0 && !matches!(element.name.as_slice(), b"face" | b"tristrips") {
            let rows = counted(element.count, "row", "rows");
            self.others
                .push(format!("{rows} of {}", quoted(&element.name)));
        }
        if element.properties.is_empty() {
            return Ok(());
        }
        for row in 0..element.count {
            for property in &element.properties {
                self.skip(property.kind)
                    .ok_or_else(|| self.broken("row", row))?;
            }
            self.body.end_row();
        }
        Ok(())
    }

    fn skip(&mut self, kind: Kind) -> Option<()> {
        match kind {
            Kind::One(scalar) => self.body.skip(scalar, 1),
            Kind::List { count, item } => {
                let length = usize::try_from(self.body.integer(count)?).ok()?;
                self.body.skip(item, length)
            }
        }
    }

    fn broken(&self, what: &str, row: usize) -> LoadFault {
        self.fault(format!(
            "{what} {row} ends early or holds something that is not its number"
        ))
    }

    fn fault(&self, problem: String) -> LoadFault {
        LoadFault::malformed(
            Ply,
            self.body.place(),
            problem,
            "export or copy the file again",
        )
    }

    fn finish(self, rest: Option<String>) -> Parsed<Soup> {
        let mut soup = self.soup;
        let mut ignored = self.others;
        if self.too_short > 0 {
            let (one, many) = ("face without three corners", "faces without three corners");
            ignored.push(counted(self.too_short, one, many));
        }
        if soup.triangles.is_empty() {
            return Err(no_triangles(soup.positions.len(), &ignored));
        }
        ignored.extend(rest.map(|rest| format!("{rest} after the last element")));
        soup.notes = ignored
            .into_iter()
            .map(|what| format!("{what} ignored"))
            .collect();
        soup.notes.extend(self.triangulator.notes());
        let (unfit, body) = (self.unfit, self.body);
        used_are_finite(&mut soup, Ply, |vertex| {
            let place = unfit.binary_search_by_key(&vertex, |one| one.0);
            let place = place.map_or_else(|_| String::new(), |i| body.place_of(unfit[i].1));
            format!("vertex {vertex} ({place})")
        })?;
        Ok(soup)
    }
}
