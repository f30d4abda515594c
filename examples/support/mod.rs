//! Parts that the examples share.

use std::path::{Path, PathBuf};

/// The folder for charts, which it makes: `charts` in cargo's target folder.
pub fn charts() -> std::io::Result<PathBuf> {
    // Tests compile some examples in a package of their own: the workspace is where the lock file is.
    let workspace = || {
        let package = Path::new(env!("CARGO_MANIFEST_DIR"));
        package.ancestors().find(|folder| folder.join("Cargo.lock").exists()).unwrap_or(package)
    };
    let target =
        std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| workspace().join("target"), PathBuf::from);
    made(target.join("charts"))
}

/// A folder, which it makes. The error says which.
pub fn made(folder: PathBuf) -> std::io::Result<PathBuf> {
    std::fs::create_dir_all(&folder).map_err(|error| at(&folder, &error))?;
    Ok(folder)
}

/// Writes a file. The error says which.
#[allow(dead_code)]
pub fn write(path: &Path, text: impl AsRef<[u8]>) -> std::io::Result<()> {
    std::fs::write(path, text).map_err(|error| at(path, &error))
}

fn at(path: &Path, error: &std::io::Error) -> std::io::Error {
    std::io::Error::new(error.kind(), format!("cannot write `{}`: {error}", path.display()))
}
