//! Packages of emitted code that cargo builds, for what only rustc can tell.

use std::path::{Path, PathBuf};

/// A package in a folder of its own, which depends on the runtime.
pub struct Package(PathBuf);

impl Package {
    /// Writes a package with this text as its library.
    pub fn new(name: &str, library: &str) -> Package {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the workspace");
        let folder = std::env::temp_dir().join(format!("lagrange-{name}-{}", std::process::id()));
        std::fs::create_dir_all(folder.join("tests")).expect("a folder for them");
        std::fs::create_dir_all(folder.join("src")).expect("a folder for them");
        let manifest = format!(
            "[package]\nname = \"{name}\"\nedition = \"2024\"\n\n[dependencies]\nlagrange-runtime = {{ path = {:?} }}\n\n[workspace]\n",
            root.join("lagrange-runtime")
        );
        std::fs::write(folder.join("src/lib.rs"), library).expect("written");
        std::fs::write(folder.join("Cargo.toml"), manifest).expect("written");
        // The versions that the workspace was tested with.
        std::fs::copy(root.join("Cargo.lock"), folder.join("Cargo.lock")).expect("copied");
        Package(folder)
    }

    /// Adds a file of tests.
    pub fn add(&self, name: &str, text: &str) {
        std::fs::write(self.0.join(format!("tests/{name}.rs")), text).expect("written");
    }

    /// Runs cargo, which succeeds.
    pub fn cargo(self, arguments: &[&str]) {
        let cargo = std::env::var("CARGO").unwrap_or("cargo".into());
        let status = std::process::Command::new(cargo)
            .args(arguments)
            .current_dir(&self.0)
            .status()
            .expect("cargo runs");
        assert!(status.success(), "the systems are in {}", self.0.display());
        std::fs::remove_dir_all(&self.0).expect("removed");
    }
}
