//! With which flags `thallus bake` gives each place of a mesh texels of its own.

use std::collections::HashMap;

use thallus::bake::{BakeError, LayoutJudgement, judge};
use thallus::substrate::{Division, Material, Substrate, Texturing};

use super::bake_args::Each;
use super::bake_parts::MOST_PARTS;

/// The flags with the fewest overlaps, the first of several.
pub(super) struct Flags {
    /// As they are written, all of their kind.
    pub(super) words: &'static str,
    pub(super) judged: LayoutJudgement,
    /// Share of the texels in use that stand for several places with the flags that are there; none where there are no
    /// maps.
    pub(super) without: Option<f64>,
}

/// What is settled.
#[derive(Clone, Copy, Default)]
pub(super) struct Settled<'a> {
    pub(super) each: &'a [Each],
    /// Whether maps are laid out in the file's second set of coordinates.
    pub(super) is_second: bool,
    /// By triangles of the file.
    pub(super) chosen: Option<&'a [bool]>,
    /// Those that lichen may be on, if that is known: parts without need no maps.
    pub(super) lichened: Option<&'a [bool]>,
}

/// Overlaps of no more than this share of the texels in use are as good as none.
const FEW: f64 = 1e-3;

/// Whether there are maps of all, in which no place shares texels with another.
fn serves(judged: &LayoutJudgement) -> bool {
    judged.unfit == 0 && are_few(judged.overlapping)
}

/// Whether there are maps of most parts: others are no advice, as those whose lichen is in none of them are refused.
fn has_most(judged: &LayoutJudgement) -> bool {
    judged.unfit <= judged.images
}

/// A layout that shows less than this share of an image wastes it.
pub(super) const WASTED: f64 = 0.02;

/// Whether so many overlaps are as good as none.
pub(super) fn are_few(share: f64) -> bool {
    share <= FEW
}

/// A layout that maps may have.
struct Choice {
    words: &'static str,
    is_second: bool,
    each: &'static [Each],
}

impl Choice {
    const fn first(words: &'static str, each: &'static [Each]) -> Self {
        Self {
            words,
            is_second: false,
            each,
        }
    }

    const fn second(words: &'static str, each: &'static [Each]) -> Self {
        Self {
            words,
            is_second: true,
            each,
        }
    }
}

/// What may be written, in the order in which it is proposed.
const CHOICES: [Choice; 9] = [
    Choice::second("--uv-set 1", &[]),
    Choice::first("--each material", &[Each::Material]),
    Choice::first("--each tile", &[Each::Tile]),
    Choice::first("--each object", &[Each::Object]),
    Choice::first(
        "--each object --each material",
        &[Each::Object, Each::Material],
    ),
    Choice::first("--each material --each tile", &[Each::Material, Each::Tile]),
    Choice::second("--uv-set 1 --each material", &[Each::Material]),
    Choice::second("--uv-set 1 --each tile", &[Each::Tile]),
    Choice::second("--uv-set 1 --each object", &[Each::Object]),
];

impl Flags {
    /// Those that add to what is settled.
    ///
    /// # Errors
    /// Why there are no maps, whatever the flags.
    pub(super) fn best(
        substrate: &Substrate,
        texturing: &Texturing,
        settled: Settled,
    ) -> Result<Self, BakeError> {
        let now = divided(texturing, settled.each);
        let now = judge(substrate, texturing, (now.as_ref(), settled.chosen));
        let without = now.as_ref().ok().map(|now| now.overlapping);
        let mut best = now.map(|judged| ("", judged));
        for choice in &CHOICES {
            if best.as_ref().is_ok_and(|(_, best)| serves(best)) {
                break;
            }
            let adds = settled.each.iter().all(|kind| choice.each.contains(kind));
            let found = adds.then(|| judged(choice, substrate, texturing, settled));
            let Some(judged) = found.flatten().filter(has_most) else {
                continue;
            };
            let order = |judged: &LayoutJudgement| (judged.unfit, judged.overlapping);
            let is_better = |(_, best): &(_, LayoutJudgement)| order(&judged) < order(best);
            if best.as_ref().map_or(true, is_better) {
                best = Ok((choice.words, judged));
            }
        }
        best.map(|(words, judged)| Self {
            words,
            judged,
            without,
        })
    }

    /// Those of them that serve, if any are needed.
    pub(super) fn that_serve(&self) -> Option<&'static str> {
        (!self.words.is_empty() && serves(&self.judged)).then_some(self.words)
    }
}

/// What to do where no flags serve.
pub(super) fn cure(texturing: &Texturing, is_second: bool) -> String {
    format!(
        "bake with --unwrap, which lays maps out in charts of its own, or {}",
        other_cure(texturing, is_second)
    )
}

fn other_cure(texturing: &Texturing, is_second: bool) -> &'static str {
    if is_second {
        return "unwrap that set of UVs without overlaps";
    }
    let has_texture = |material: &Material| material.base_color_texture.is_some();
    match texturing.materials.iter().any(has_texture) {
        true => {
            "give the mesh a second set of UVs without overlaps, which leaves its textures where they are, export it as \
             glTF, and bake with --uv-set 1 (in Blender: Object Data > UV Maps > +, then in Edit Mode UV > Smart UV \
             Project)"
        }
        false => {
            "unwrap the mesh without overlaps (in Blender: in Edit Mode UV > Smart UV Project)"
        }
    }
}

/// What to do where the mesh has no UVs, or none with area.
pub(super) const UNWRAP: &str = "with --unwrap maps are laid out in charts of their own; or unwrap it in the program that \
     made it (in Blender: Edit Mode, UV > Smart UV Project), export it as glTF or OBJ with UVs, and give that with --mesh";

/// Nothing where they ask for what there is not, or for no more than there is.
fn judged(
    choice: &Choice,
    substrate: &Substrate,
    texturing: &Texturing,
    settled: Settled,
) -> Option<LayoutJudgement> {
    let second = match choice.is_second {
        true if settled.is_second => return None,
        true => Some(in_second(texturing)?),
        false => None,
    };
    let laid_out = second.as_ref().unwrap_or(texturing);
    if choice.each.is_empty() {
        return judge(substrate, laid_out, (None, settled.chosen)).ok();
    }
    if choice.each.contains(&Each::Tile) && repeats_images(laid_out) {
        return None;
    }
    let division = divided(laid_out, choice.each)?;
    let is_possible = (2..=MOST_PARTS).contains(&division.count_in(settled.chosen));
    let chosen = chosen(&division, settled);
    let chosen = chosen.as_deref().or(settled.chosen);
    is_possible.then(|| judge(substrate, laid_out, (Some(&division), chosen)).ok())?
}

/// What a layout in the second set of coordinates goes by, if there is one: all but normals, colours and images.
fn in_second(texturing: &Texturing) -> Option<Texturing> {
    let is_there = texturing.second_uvs.iter().any(Option::is_some);
    is_there.then(|| {
        let mut second = Texturing {
            uvs: texturing.uvs.clone(),
            second_uvs: texturing.second_uvs.clone(),
            parts: texturing.parts.clone(),
            part_of: texturing.part_of.clone(),
            material_of: texturing.material_of.clone(),
            materials: texturing.materials.clone(),
            ..Texturing::default()
        };
        second.swap_uv_sets();
        second
    })
}

/// Of a division the triangles in parts that lichen is on, if that is known.
fn chosen(division: &Division, settled: Settled) -> Option<Vec<bool>> {
    let lichened = settled.lichened?;
    let mut carries = vec![false; division.names().len()];
    for (triangle, _) in lichened.iter().enumerate().filter(|(_, is)| **is) {
        division
            .place_of(triangle)
            .into_iter()
            .for_each(|part| carries[part] = true);
    }
    let is_chosen = |triangle: usize| {
        settled
            .chosen
            .is_none_or(|chosen| chosen.get(triangle) == Some(&true))
            && division
                .place_of(triangle)
                .is_some_and(|part| carries[part])
    };
    Some((0..division.triangles()).map(is_chosen).collect())
}

/// By all of some kinds; nothing where there are none, or the file has no such names.
fn divided(texturing: &Texturing, each: &[Each]) -> Option<Division> {
    let by = |each: &Each| match each {
        Each::Object => Division::by_object(texturing).ok(),
        Each::Material => Division::by_material(texturing).ok(),
        Each::Tile => Some(Division::by_tile(texturing)),
    };
    let all: Option<Vec<Division>> = each.iter().map(by).collect();
    all?.into_iter().reduce(|a, b| a.and(&b))
}

/// Whether an image lies on several tiles: so it is repeated, and they are none of UDIM's, which have an image each.
fn repeats_images(texturing: &Texturing) -> bool {
    let tiles = Division::by_tile(texturing);
    let mut tile_of = HashMap::new();
    let mut triangles = texturing.material_of.iter().enumerate();
    triangles.any(|(triangle, material)| {
        let image = || {
            let material = texturing.materials.get((*material)? as usize)?;
            let texture = material.base_color_texture?;
            (!texture.is_in_second).then_some(texture.image)
        };
        let tile = tiles.name_of(triangle);
        image().is_some_and(|image| *tile_of.entry(image).or_insert(tile) != tile)
    })
}
