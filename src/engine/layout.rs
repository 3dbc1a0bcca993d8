//! What a shader has to know of the tables of an engine.

use super::profile::{Profile, Sizes};
use super::sheet::Along;
use crate::shader::TextureLayout;
use crate::table::axis::AxisError;

impl Profile {
    /// The textures of its tables, by the names of the files that it has them in.
    ///
    /// # Errors
    /// [`AxisError`] for sizes that no axis has.
    pub fn layouts(self, sizes: Sizes) -> Result<Vec<TextureLayout>, AxisError> {
        let layout = |sheet: &super::Sheet| {
            let extension = self.format_of(sheet).extensions()[0];
            Ok(TextureLayout {
                id: sheet.name.into(),
                file: format!("{}.{extension}", sheet.name),
                axes: sheet.axes.iter().map(Along::axis).collect::<Result<_, _>>()?,
                channels: sheet.channels.iter().map(|term| term.channel()).collect(),
            })
        };
        self.sheets(sizes).iter().map(layout).collect()
    }
}
