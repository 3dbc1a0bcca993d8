//! A headless browser that opens a page, reads the furnace in it, and tries its controls.

use crate::skip::skip;
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, PoisonError};

/// One browser at a time: each takes hundreds of megabytes, and they draw without a graphics card.
static ONE: Mutex<()> = Mutex::new(());

/// Where chromium lives on the systems that package it.
const BROWSERS: [&str; 4] = [
    "/usr/bin/chromium",
    "/usr/bin/chromium-browser",
    "/usr/bin/google-chrome",
    "/snap/bin/chromium",
];

/// What the driver is asked to do with a page.
#[derive(Default)]
pub(crate) struct Visit {
    /// Choices for `window.furnace.read`.
    pub(crate) reads: Vec<Value>,
    /// Whether to try every control by the keyboard.
    pub(crate) keyboard: bool,
    /// A directory for pictures.
    pub(crate) shots: Option<PathBuf>,
}

/// Opens `page` and tells what was seen; `None`, saying so, where the programs for it are missing.
///
/// # Panics
/// Where they are missing and FURNACE_REQUIRE_BROWSER is 1, and when the browser fails.
pub(crate) fn visit(page: &Path, visit: &Visit) -> Option<Value> {
    let library = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/node/node_modules/playwright-core");
    let chromium = BROWSERS.iter().find(|path| Path::new(path).exists());
    let has_node = Command::new("node").arg("--version").output().is_ok();
    let missing = match chromium {
        None => "chromium",
        Some(_) if !has_node => "node",
        Some(_) if !library.exists() => "the npm package playwright-core in target/node",
        Some(_) => "",
    };
    if !missing.is_empty() {
        let must = std::env::var("FURNACE_REQUIRE_BROWSER").is_ok_and(|value| value == "1");
        assert!(!must, "{missing} is missing");
        skip(format!("{missing} is missing, no browser opens the page"));
        return None;
    }
    if let Some(shots) = &visit.shots {
        fs::create_dir_all(shots).unwrap();
    }
    let asked = json!({
        "library": library,
        "chromium": chromium,
        "page": page,
        "reads": visit.reads,
        "keyboard": visit.keyboard,
        "shots": visit.shots,
    });
    let _one = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    let output = Command::new("node")
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/view/drive.mjs"))
        .arg(asked.to_string())
        .output()
        .unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "the browser failed: {errors}");
    Some(serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {errors}")))
}

/// What holds of every page: it loads without a complaint and asks nobody for anything.
pub(crate) fn assert_quiet(seen: &Value, page: &Path) {
    assert_eq!(seen["complaints"], json!([]));
    assert_eq!(seen["trouble"], "");
    let own = format!("file://{}", page.display());
    let requests = seen["requests"].as_array().unwrap();
    assert!(
        !requests.is_empty() && requests.iter().all(|address| *address == own),
        "{requests:?}"
    );
    for (device, width) in seen["widths"].as_object().unwrap() {
        let [content, window] = [&width[0], &width[1]].map(|value| value.as_f64().unwrap());
        assert!(content <= window, "{device}: {content} pixels in a window of {window}");
    }
}
