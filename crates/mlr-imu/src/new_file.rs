use std::{
    fs::File,
    io::{self, Seek},
    path::{Path, PathBuf},
};

/// A file that appears under its name only when it is complete, and never in the place of
/// another.
///
/// Nothing is left in the folder when the program is stopped while the content is still
/// being worked out, nor, where the system has files without a name (Linux), while it is
/// written.
#[derive(Debug)]
pub struct NewFile {
    path: PathBuf,
}

impl NewFile {
    /// Makes sure that a file of this name can be made, which is better known before long
    /// work than after it.
    ///
    /// # Errors
    /// [`io::ErrorKind::AlreadyExists`] when there is one already; whatever the folder
    /// answers when nothing can be written there.
    pub fn reserve(path: &Path) -> io::Result<Self> {
        if path.exists() {
            return Err(already_exists());
        }
        // Without a name from the beginning, where the system can do that.
        tempfile::tempfile_in(folder_of(path))?;
        Ok(Self { path: path.into() })
    }

    /// Has the content written and gives the file its name. Others may read it as far as the
    /// user's umask lets them, like any new file. Returns its size in bytes.
    ///
    /// # Errors
    /// What `content` returns, and [`io::ErrorKind::AlreadyExists`] when a file of that name has
    /// appeared since; it stays as it is.
    pub fn write<E: From<io::Error>>(
        &self,
        content: impl FnOnce(&mut File) -> Result<(), E>,
    ) -> Result<u64, E> {
        let mut file = tempfile::tempfile_in(folder_of(&self.path))?;
        content(&mut file)?;
        let size = file.metadata()?.len();
        match give_name(&file, &self.path) {
            Ok(()) => Ok(size),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                Err(already_exists().into())
            }
            // The system or the folder's file system cannot do that.
            Err(_) => {
                self.copy(&mut file)?;
                Ok(size)
            }
        }
    }

    /// Puts the content into a file with a temporary name first, which then gets its own.
    fn copy(&self, content: &mut File) -> io::Result<()> {
        #[cfg_attr(not(unix), allow(unused_mut, reason = "only Unix has modes"))]
        let mut builder = tempfile::Builder::new();
        // A temporary file's own default is private.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let mut file = builder.tempfile_in(folder_of(&self.path))?;
        content.rewind()?;
        io::copy(content, file.as_file_mut())?;
        file.persist_noclobber(&self.path)
            .map_err(|failure| match failure.error.kind() {
                io::ErrorKind::AlreadyExists => already_exists(),
                _ => failure.error,
            })?;
        Ok(())
    }
}

/// Gives a file without a name one, which no file may have yet.
#[cfg(target_os = "linux")]
fn give_name(file: &File, path: &Path) -> io::Result<()> {
    use std::os::fd::AsRawFd;

    use rustix::fs::{AtFlags, CWD, linkat};

    let unnamed = format!("/proc/self/fd/{}", file.as_raw_fd());
    Ok(linkat(CWD, unnamed, CWD, path, AtFlags::SYMLINK_FOLLOW)?)
}

#[cfg(not(target_os = "linux"))]
fn give_name(_: &File, _: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

fn already_exists() -> io::Error {
    io::Error::new(
        io::ErrorKind::AlreadyExists,
        "already exists and is not overwritten",
    )
}

#[cfg(test)]
mod tests {
    use std::{fs, io::Write};

    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect()
    }

    #[test]
    fn it_appears_when_it_is_complete() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("answer.json");
        let file = NewFile::reserve(&path).unwrap();
        assert!(names(folder.path()).is_empty());
        let size = file.write(|file| {
            file.write_all(b"half")?;
            assert!(!path.exists());
            file.write_all(b" and half")
        });
        assert_eq!(size.unwrap(), 13);
        assert_eq!(names(folder.path()), ["answer.json"]);
        #[cfg(unix)]
        {
            let mode = |path| std::os::unix::fs::MetadataExt::mode(&fs::metadata(path).unwrap());
            let usual = folder.path().join("usual");
            fs::write(&usual, "").unwrap();
            assert_eq!(mode(&path), mode(&usual));
        }
    }

    #[test]
    fn a_file_system_without_unnamed_files_gets_a_copy() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("answer.json");
        let file = NewFile::reserve(&path).unwrap();
        let mut content = tempfile::tempfile().unwrap();
        content.write_all(b"whole").unwrap();
        file.copy(&mut content).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "whole");
        let again = file.copy(&mut content).unwrap_err();
        assert_eq!(again.kind(), io::ErrorKind::AlreadyExists);
        assert_eq!(names(folder.path()), ["answer.json"]);
    }

    #[test]
    fn a_failure_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let file = NewFile::reserve(&folder.path().join("answer.json")).unwrap();
        let failed = file.write(|file| {
            file.write_all(b"half")?;
            Err(io::Error::other("no more"))
        });
        assert_eq!(failed.unwrap_err().to_string(), "no more");
        assert!(names(folder.path()).is_empty());
        let nowhere = folder.path().join("no such folder").join("answer.json");
        let missing = NewFile::reserve(&nowhere).unwrap_err();
        assert_eq!(missing.kind(), io::ErrorKind::NotFound);
    }

    #[test]
    fn what_is_there_stays() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mine.json");
        let file = NewFile::reserve(&path).unwrap();
        fs::write(&path, "precious").unwrap();
        let late = file.write(|file| file.write_all(b"mine"));
        assert_eq!(late.unwrap_err().kind(), io::ErrorKind::AlreadyExists);
        let early = NewFile::reserve(&path).unwrap_err();
        assert_eq!(early.kind(), io::ErrorKind::AlreadyExists);
        assert_eq!(fs::read_to_string(&path).unwrap(), "precious");
        assert_eq!(names(folder.path()), ["mine.json"]);
    }
}
