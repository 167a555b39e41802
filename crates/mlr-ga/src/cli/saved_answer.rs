//! Answers that were saved as JSON.

use std::{error::Error, path::Path};

use anyhow::Context;
use mlr_imu::{MAX_TEXT_BYTES, read_text};

/// What is made of the answer in a file; errors name the file.
pub(super) fn saved_answer<Answer, E: Error + Send + Sync + 'static>(
    path: &Path,
    read: impl FnOnce(&str) -> Result<Answer, E>,
) -> anyhow::Result<Answer> {
    let name = || path.display().to_string();
    let text = read_text(path, MAX_TEXT_BYTES).with_context(name)?;
    read(&text).with_context(name)
}
