//! glTF accessors: typed elements in a view, dequantized, sparse replacements applied.
//!
//! Integers are dequantized as `KHR_mesh_quantization` and section 3.11 of the specification say:
//! unnormalized as they are, normalized by the largest value of their type, clamped to −1.

use std::cell::Cell;

use super::Format;
use super::error::{LoadFault, Parsed};
use super::gltf_buffers::{Buffers, EXPORT_AGAIN, View};
use super::gltf_schema::{Accessor, Root, Sparse};

/// Most elements of an accessor without data of its own (all zeros, unless sparse).
const MOST_UNBACKED: usize = 1 << 20;

/// Most elements that are read of a document: primitives may name one accessor again and again, and one without data
/// takes no bytes of the file.
const MOST_READ: usize = 1 << 29;

/// Reads accessors of one document.
pub(super) struct Accessors<'a> {
    pub(super) root: &'a Root<'a>,
    pub(super) buffers: Buffers<'a>,
    pub(super) format: Format,
    read: Cell<usize>,
}

#[derive(Clone, Copy, PartialEq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn from_code(code: u32) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The value that a normalized integer divides by.
    fn largest(self) -> f64 {
        match self {
            Self::I8 => 127.0,
            Self::U8 => 255.0,
            Self::I16 => 32_767.0,
            Self::U16 => 65_535.0,
            Self::U32 => 4_294_967_295.0,
            Self::F32 => 1.0,
        }
    }

    fn read(self, at: &[u8]) -> f64 {
        match self {
            Self::I8 => f64::from(at[0] as i8),
            Self::U8 => f64::from(at[0]),
            Self::I16 => f64::from(i16::from_le_bytes([at[0], at[1]])),
            Self::U16 => f64::from(u16::from_le_bytes([at[0], at[1]])),
            Self::U32 => f64::from(u32::from_le_bytes([at[0], at[1], at[2], at[3]])),
            Self::F32 => f64::from(f32::from_le_bytes([at[0], at[1], at[2], at[3]])),
        }
    }
}

/// Equally spaced elements, checked to lie within their bytes.
struct Elements<'v> {
    bytes: &'v [u8],
    stride: usize,
    count: usize,
    component: Component,
}

impl Elements<'_> {
    fn iter(&self) -> impl Iterator<Item = &[u8]> {
        // The last element may end before its stride does.
        (0..self.count).map(|i| &self.bytes[i * self.stride..])
    }
}

impl<'a> Accessors<'a> {
    pub(super) fn new(root: &'a Root<'a>, buffers: Buffers<'a>, format: Format) -> Self {
        Self {
            root,
            buffers,
            format,
            read: Cell::new(0),
        }
    }

    /// Accessor `index`.
    pub(super) fn get(&self, index: usize, place: &str) -> Parsed<&'a Accessor<'a>> {
        let known = self.root.accessors.len();
        self.root.accessors.get(index).ok_or_else(|| {
            self.fault(
                place,
                index,
                format!("there is no such accessor, the file has {known}"),
            )
        })
    }

    /// The vectors of accessor `index`, or its matrices of 16 numbers, dequantized to real numbers.
    pub(super) fn vectors<const N: usize>(
        &self,
        index: usize,
        place: &str,
    ) -> Parsed<Vec<[f64; N]>> {
        let mut vectors = Vec::new();
        self.append_vectors(index, place, &mut vectors)?;
        Ok(vectors)
    }

    /// Puts them behind others.
    pub(super) fn append_vectors<const N: usize>(
        &self,
        index: usize,
        place: &str,
        out: &mut Vec<[f64; N]>,
    ) -> Parsed<()> {
        let accessor = self.get(index, place)?;
        let expected = match N {
            16 => "MAT4".to_owned(),
            _ => format!("VEC{N}"),
        };
        if accessor.lanes != expected {
            let problem = format!("its type is {}, not {expected}", accessor.lanes);
            return Err(self.fault(place, index, problem));
        }
        let component = self.component(accessor.component_type, place, index)?;
        let largest = if accessor.normalized {
            component.largest()
        } else {
            1.0
        };
        let vector = |bytes: &[u8]| -> [f64; N] {
            std::array::from_fn(|lane| {
                let raw = component.read(&bytes[lane * component.size()..]);
                // Divided, not multiplied by the inverse, so that the largest integer is exactly 1.
                if largest == 1.0 {
                    raw
                } else {
                    (raw / largest).max(-1.0)
                }
            })
        };
        let start = out.len();
        match self.elements(index, accessor, component, N, place)? {
            Some(elements) => out.extend(elements.iter().map(vector)),
            None => out.resize(start + accessor.count, [0.0; N]),
        }
        if let Some(sparse) = &accessor.sparse {
            let values = self.sparse_values(index, sparse, component, N, place)?;
            let targets = self.sparse_targets(index, accessor, sparse, place)?;
            for (target, bytes) in targets.into_iter().zip(values.iter()) {
                out[start + target as usize] = vector(bytes);
            }
        }
        Ok(())
    }

    /// The indices in accessor `index`, widened.
    pub(super) fn indices(&self, index: usize, place: &str) -> Parsed<Vec<u32>> {
        let accessor = self.get(index, place)?;
        if accessor.lanes != "SCALAR" {
            let problem = format!("its type is {}, indices are SCALAR", accessor.lanes);
            return Err(self.fault(place, index, problem));
        }
        let component = self.index_component(accessor.component_type, place, index)?;
        let mut indices = match self.elements(index, accessor, component, 1, place)? {
            Some(elements) => read_indices(&elements),
            None => vec![0; accessor.count],
        };
        if let Some(sparse) = &accessor.sparse {
            let values = self.sparse_values(index, sparse, component, 1, place)?;
            let targets = self.sparse_targets(index, accessor, sparse, place)?;
            for (target, value) in targets.into_iter().zip(read_indices(&values)) {
                indices[target as usize] = value;
            }
        }
        Ok(indices)
    }

    fn component(&self, code: u32, place: &str, index: usize) -> Parsed<Component> {
        Component::from_code(code)
            .ok_or_else(|| self.fault(place, index, format!("component type {code} is unknown")))
    }

    fn index_component(&self, code: u32, place: &str, index: usize) -> Parsed<Component> {
        match self.component(code, place, index)? {
            component @ (Component::U8 | Component::U16 | Component::U32) => Ok(component),
            _ => Err(self.fault(place, index, "indices must be unsigned integers".into())),
        }
    }

    /// The stored elements; `None` for an accessor without a view, which is all zeros.
    fn elements(
        &self,
        index: usize,
        accessor: &Accessor,
        component: Component,
        lanes: usize,
        place: &str,
    ) -> Parsed<Option<Elements<'_>>> {
        let sparse = accessor.sparse.as_ref().map_or(0, |sparse| sparse.count);
        if sparse > accessor.count {
            let problem = format!("{sparse} sparse elements, of {}", accessor.count);
            return Err(self.fault(place, index, problem));
        }
        let Some(view) = accessor.buffer_view else {
            if accessor.count > MOST_UNBACKED {
                let problem = format!("{} elements without any data", accessor.count);
                return Err(self.fault(place, index, problem));
            }
            return self.charge(index, accessor.count, place).map(|()| None);
        };
        let view = self.view(view, place, index)?;
        let elements = within(view, accessor.byte_offset, accessor.count, component, lanes)
            .map_err(|problem| self.fault(place, index, problem))?;
        self.charge(index, accessor.count, place)
            .map(|()| Some(elements))
    }

    fn charge(&self, index: usize, count: usize, place: &str) -> Parsed<()> {
        let read = self.read.get().saturating_add(count);
        self.read.set(read);
        if read <= MOST_READ {
            return Ok(());
        }
        let problem = "accessors are read again and again, 500 million elements by now";
        Err(self.fault(place, index, problem.into()))
    }

    fn sparse_values(
        &self,
        index: usize,
        sparse: &Sparse,
        component: Component,
        lanes: usize,
        place: &str,
    ) -> Parsed<Elements<'_>> {
        let view = self.view(sparse.values.buffer_view, place, index)?;
        within(
            view,
            sparse.values.byte_offset,
            sparse.count,
            component,
            lanes,
        )
        .map_err(|problem| self.fault(place, index, format!("sparse values: {problem}")))
    }

    fn sparse_targets(
        &self,
        index: usize,
        accessor: &Accessor,
        sparse: &Sparse,
        place: &str,
    ) -> Parsed<Vec<u32>> {
        let component = self.index_component(sparse.indices.component_type, place, index)?;
        let view = self.view(sparse.indices.buffer_view, place, index)?;
        let targets = within(view, sparse.indices.byte_offset, sparse.count, component, 1)
            .map(|elements| read_indices(&elements))
            .map_err(|problem| self.fault(place, index, format!("sparse indices: {problem}")))?;
        match targets
            .iter()
            .find(|&&target| target as usize >= accessor.count)
        {
            None => Ok(targets),
            Some(target) => {
                let problem = format!("sparse index {target}, but {} elements", accessor.count);
                Err(self.fault(place, index, problem))
            }
        }
    }

    fn view(&self, view: usize, place: &str, index: usize) -> Parsed<View<'_>> {
        self.buffers
            .view(view)
            .map_err(|fault| within_accessor(fault, place, index))
    }

    fn fault(&self, place: &str, index: usize, problem: String) -> LoadFault {
        let place = format!("{place}, accessor {index}");
        LoadFault::malformed(self.format, place, problem, EXPORT_AGAIN)
    }
}

/// The elements at `offset` in a view, if the last one ends inside.
fn within(
    view: View<'_>,
    offset: usize,
    count: usize,
    component: Component,
    lanes: usize,
) -> Result<Elements<'_>, String> {
    let size = lanes * component.size();
    let stride = view.stride.unwrap_or(size);
    if stride < size {
        return Err(format!(
            "elements of {size} bytes overlap at byteStride {stride}"
        ));
    }
    let end = count
        .checked_sub(1)
        .map_or(Some(0), |steps| {
            steps.checked_mul(stride)?.checked_add(size)
        })
        .and_then(|length| length.checked_add(offset))
        .filter(|&end| end <= view.bytes.len());
    match end {
        Some(_) => Ok(Elements {
            bytes: &view.bytes[offset..],
            stride,
            count,
            component,
        }),
        None => Err(format!(
            "{count} elements of {stride} bytes from {offset} reach beyond the view's {} bytes",
            view.bytes.len()
        )),
    }
}

/// Puts the accessor in front of a fault found further down.
fn within_accessor(fault: LoadFault, place: &str, index: usize) -> LoadFault {
    match fault {
        LoadFault::Malformed {
            format,
            place: inner,
            problem,
            cure,
        } => LoadFault::Malformed {
            format,
            place: format!("{place}, accessor {index}, {inner}"),
            problem,
            cure,
        },
        other => other,
    }
}

fn read_indices(elements: &Elements) -> Vec<u32> {
    match elements.component {
        Component::U8 => elements.iter().map(|b| u32::from(b[0])).collect(),
        Component::U16 => elements
            .iter()
            .map(|b| u32::from(u16::from_le_bytes([b[0], b[1]])))
            .collect(),
        _ => elements
            .iter()
            .map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
            .collect(),
    }
}
