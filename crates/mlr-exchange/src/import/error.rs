use thiserror::Error;

/// Why a URDF cannot be read as a robot.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{}{what}", self.place())]
pub struct ImportError {
    /// Line of the file, from 1, where it is known.
    pub line: Option<usize>,
    /// What was found and what was expected.
    pub what: String,
}

impl ImportError {
    pub(super) fn at(line: usize, what: impl Into<String>) -> Self {
        Self {
            line: Some(line),
            what: what.into(),
        }
    }

    pub(super) fn of_file(what: impl Into<String>) -> Self {
        Self {
            line: None,
            what: what.into(),
        }
    }

    fn place(&self) -> String {
        self.line
            .map_or(String::new(), |line| format!("line {line}: "))
    }
}
