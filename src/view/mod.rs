//! A page that shows tables at work: one HTML file with everything in it, for a browser with WebGL 2.
//!
//! | stage | file | takes | gives |
//! | --- | --- | --- | --- |
//! | cast | `cast.rs` | a scene | the materials and lobes that the page can show, and why not the others |
//! | sheets | `sheets.rs` | a lobe | its albedos over (mu, roughness): tables of several sizes, and a dense reference |
//! | data | `data.rs` | both | what the page reads, as JSON |
//! | page | `page.rs` | that, and [`crate::shader::library`] | the file: style, scripts, shaders and data in one, and a policy that forbids it the network |
//!
//! The page computes nothing that it could have been told: it samples the tables as a shader does and integrates the lobe itself
//! over the hemisphere, which is what tables are tried by, and compares with albedos that [`crate::integrate`] has computed.

mod base64;
mod cast;
mod data;
mod page;
mod sheets;

pub use cast::{Cast, CastError, LeftOut, MOST_SHEETS, Part, Surface, Term};
pub use page::{PageError, html};
pub use sheets::{SIZES, STORAGES, SheetError, Sheets, TOLERANCE, sheets, work};
