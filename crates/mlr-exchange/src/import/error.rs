use thiserror::Error;

/// Why a URDF cannot be read as a robot.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{}{what}", self.place())]
pub struct ImportError {
    /// Line of the file, from 1, where it is known.
    pub line: Option<usize>,
    /// What was found and what was expected.
    pub what: String,
    offset: Option<usize>,
}

impl ImportError {
    /// At a byte of the file, whose line is found by [`located`](Self::located).
    pub(super) fn at(offset: usize, what: impl Into<String>) -> Self {
        Self {
            offset: Some(offset),
            ..Self::of_file(what)
        }
    }

    pub(super) fn at_line(line: usize, what: impl Into<String>) -> Self {
        Self {
            line: Some(line),
            ..Self::of_file(what)
        }
    }

    pub(super) fn of_file(what: impl Into<String>) -> Self {
        Self {
            line: None,
            what: what.into(),
            offset: None,
        }
    }

    /// With its line in the text of the file.
    pub(super) fn located(mut self, text: &str) -> Self {
        if let Some(before) = self.offset.and_then(|offset| text.get(..offset)) {
            self.line = Some(1 + before.matches('\n').count());
        }
        self
    }

    fn place(&self) -> String {
        self.line
            .map_or(String::new(), |line| format!("line {line}: "))
    }
}
