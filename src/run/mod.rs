//! A run: recipe, execution, the loop that grows, and who watches it.

mod driver;
mod execution;
mod length;
mod loose;
mod mask;
mod names;
mod observer;
mod parameter;
mod places;
pub mod preset;
mod recipe;
mod recipe_keys;
mod recipe_text;
mod report;
mod said;
mod seed_text;
mod settings;
mod settings_error;
mod slope_text;
mod toml_values;

pub use crate::growth::{SeedPlace, Slope};
pub use crate::substrate::AUTO_RADII_PER_DIAGONAL;
pub use driver::{Begun, GrowError, Growth, Run, Stopped, grow};
pub use execution::Execution;
pub use length::{Length, LengthError};
pub use mask::{EXPOSED, MaskId, NO_MASK, OPAQUE, SECOND_UVS, VERTEX_COLORS};
pub use observer::{Observer, Progress, Watch, watch};
pub use parameter::{
    BIAS, COLONIES, COVER, CURVATURE_RADIUS, DEFAULT_CURVATURE_RADII, DEFAULT_ELEMENTS, ELEMENTS,
    GAIN, KILL, LAUNCH, MIN_STICK, PARAMETERS, ParameterInfo, RADIUS, REACH,
};
pub(crate) use places::Places;
pub use recipe::{MeshId, Recipe, StopRule};
pub(crate) use recipe_keys::{AXES, line_at, not_toml};
pub use recipe_text::{RecipeFileError, RecipeTextError};
pub use report::{MeshSummary, RunReport, Timings};
pub(crate) use said::unquoted;
pub use said::{UnknownSetting, shell_path, shell_word};
pub use seed_text::SeedTextError;
pub use settings::{Complete, Settings, StopSetting};
pub use settings_error::SettingsError;
pub use slope_text::SlopeTextError;
