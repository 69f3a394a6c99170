//! What a mesh file holds, before anything is welded or judged.

/// Triangles as a file gave them: the loaders' common output.
///
/// Every polygon is already triangulated and every node transform applied. Vertices may be split
/// at seams, unreferenced, duplicated or degenerate: [`Substrate::from_soup`] deals with that.
/// Every index is in range and every position finite; loaders refuse triangles without one.
///
/// [`Substrate::from_soup`]: crate::substrate::Substrate::from_soup
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Soup {
    /// Vertex positions in the file's own units and axes.
    pub positions: Vec<[f64; 3]>,
    /// Corner indices into `positions`, in the file's order.
    pub triangles: Vec<[u32; 3]>,
    /// What the loader had to interpret or pass over, in words for the user
    /// (`"12 polygons triangulated"`, `"3 line primitives ignored"`).
    pub notes: Vec<String>,
}
