//! Files that are replaced as a whole.

use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// Writes a file so that whoever reads it, after a crash too, finds either what was there before or all of `bytes`:
/// they are written beside it, brought to the disk, and moved into its place.
pub fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let beside = beside(path);
    let written = File::create(&beside).and_then(|mut file| {
        file.write_all(bytes)?;
        file.sync_all()
    });
    if let Err(error) = written.and_then(|()| fs::rename(&beside, path)) {
        // What is left of it is of no use. That it cannot be removed, is no news beside the error.
        let _ = fs::remove_file(&beside);
        return Err(error);
    }
    // The new name has to reach the disk too. Where folders cannot be opened as files, this is left to the system.
    if let Ok(folder) = File::open(folder(path)) {
        let _ = folder.sync_all();
    }
    Ok(())
}

fn folder(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// The name under which a file is written: always the same, so that crashes do not leave many.
fn beside(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".part");
    name.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_written_leaves_the_old_file() {
        let folder = std::env::temp_dir().join(format!("lagrange-file-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder");
        let path = folder.join("result");
        replace(&path, b"old").expect("written");
        // A folder stands where the new file is to be written.
        fs::create_dir(beside(&path)).expect("a folder");
        assert!(replace(&path, b"new").is_err());
        assert_eq!(fs::read(&path).expect("there"), b"old");
        fs::remove_dir(beside(&path)).expect("removed");
        replace(&path, b"new").expect("written");
        assert_eq!(fs::read(&path).expect("there"), b"new");
        assert!(!beside(&path).exists());
        assert!(replace(&folder.join("no/such/folder"), b"").is_err());
        fs::remove_dir_all(folder).expect("removed");
    }
}
