//! What the examples share.

use std::path::{Path, PathBuf};

/// The folder for charts, which it makes: `charts` in cargo's target folder.
pub fn charts() -> std::io::Result<PathBuf> {
    let target = std::env::var_os("CARGO_TARGET_DIR")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("target"), PathBuf::from);
    let folder = target.join("charts");
    std::fs::create_dir_all(&folder)?;
    Ok(folder)
}
