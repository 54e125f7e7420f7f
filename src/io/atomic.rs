//! Atomic replacement of files.

use std::fs::{self, File};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::NamedTempFile;

use super::error::{SaveError, SaveErrorKind};

/// Calls `fill` to write a temporary file beside `path`, then renames it to `path`.
///
/// The data is on the disk before the renaming, so after any failure either the old or the new file
/// exists, and no temporary file remains. The permissions of an existing file are kept; hard links
/// to it keep the old contents. Symbolic links are followed. Devices and pipes are written
/// directly.
///
/// # Errors
/// [`SaveError`]; the old file is unchanged.
pub(super) fn replace(
    path: &Path,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), SaveError> {
    let target = target(path)?;
    let failed = |error: io::Error| from_io(path, error);
    if let Some(kept) = &target.existing
        && !kept.is_file()
    {
        let file = File::options()
            .write(true)
            .open(&target.path)
            .map_err(failed)?;
        return fill_file(file, fill).map(drop).map_err(failed);
    }
    let (temporary, _unfinished) = unfinished_in(&target.directory).map_err(failed)?;
    let (file, name) = temporary.into_parts();
    let file = fill_file(file, fill).map_err(failed)?;
    if let Some(kept) = &target.existing {
        file.set_permissions(kept.permissions()).map_err(failed)?;
    }
    file.sync_all().map_err(failed)?;
    drop(file);
    name.persist(&target.path).map_err(|e| failed(e.error))?;
    // Sync the new name as well. A file system without this operation has nothing to sync.
    if cfg!(unix)
        && let Ok(directory) = File::open(&target.directory)
    {
        directory.sync_all().ok();
    }
    Ok(())
}

/// Checks that [`replace`] can start: a new file can be created in the directory.
pub(super) fn probe(path: &Path) -> Result<(), SaveError> {
    let target = target(path)?;
    if target.existing.as_ref().is_none_or(fs::Metadata::is_file) {
        unfinished_in(&target.directory).map_err(|e| from_io(path, e))?;
    }
    Ok(())
}

/// The temporary files that exist at present.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes a temporary file from the list when it is dropped.
struct Unfinished(PathBuf);

impl Drop for Unfinished {
    fn drop(&mut self) {
        unfinished().retain(|path| *path != self.0);
    }
}

/// A temporary file and its place in the list.
fn unfinished_in(directory: &Path) -> io::Result<(NamedTempFile, Unfinished)> {
    let mut list = unfinished();
    let file = temporary_in(directory)?;
    let path = file.path().to_owned();
    list.push(path.clone());
    Ok((file, Unfinished(path)))
}

/// Removes the temporary files of this process, for a program that is about to end; the files that
/// they were to replace are not changed. Later saves wait without end.
pub fn abandon_unfinished() {
    let list = unfinished();
    for path in list.iter() {
        fs::remove_file(path).ok();
    }
    std::mem::forget(list);
}

/// A temporary file that is removed unless it is persisted.
fn temporary_in(directory: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".meniscus-").suffix(".tmp");
    #[cfg(unix)]
    {
        // The mode of a new file, which the umask reduces, instead of 0600 for a temporary file.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(directory)
}

fn fill_file(file: File, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<File> {
    let mut buffer = BufWriter::with_capacity(1 << 18, file);
    fill(&mut buffer)?;
    buffer.into_inner().map_err(io::IntoInnerError::into_error)
}

/// The resolved target of the data.
struct Target {
    path: PathBuf,
    directory: PathBuf,
    existing: Option<fs::Metadata>,
}

/// Follows links and makes all checks that are possible before the computation.
fn target(path: &Path) -> Result<Target, SaveError> {
    let existing = match fs::metadata(path) {
        Ok(metadata) if metadata.is_dir() => return Err(SaveErrorKind::IsDirectory.of(path)),
        Ok(metadata) if metadata.permissions().readonly() => {
            return Err(SaveErrorKind::ReadOnly.of(path));
        }
        Ok(metadata) => Some(metadata),
        Err(error) if error.kind() == ErrorKind::NotFound => None,
        Err(error) if error.kind() == ErrorKind::NotADirectory => {
            return Err(SaveErrorKind::DirectoryMissing(parent(path)).of(path));
        }
        Err(error) => return Err(from_io(path, error)),
    };
    let real = if existing.is_some() {
        fs::canonicalize(path).map_err(|e| from_io(path, e))?
    } else {
        path.to_owned()
    };
    let directory = parent(&real);
    if !directory.is_dir() {
        return Err(SaveErrorKind::DirectoryMissing(directory).of(path));
    }
    Ok(Target {
        path: real,
        directory,
        existing,
    })
}

fn parent(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

fn from_io(path: &Path, source: io::Error) -> SaveError {
    let kind = match source.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge => {
            SaveErrorKind::DiskFull
        }
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            SaveErrorKind::PermissionDenied
        }
        _ => SaveErrorKind::Write(source),
    };
    kind.of(path)
}
