//! Tables in Markdown that read well as they are.

/// A table whose columns are padded to one width each.
#[derive(Debug)]
pub(super) struct MarkdownTable {
    /// Head and rows; each has as many cells as the head.
    rows: Vec<Vec<String>>,
    right: Vec<bool>,
}

impl MarkdownTable {
    /// A table with these columns; the names of those with numbers end in `>`, which puts them on
    /// the right.
    pub(super) fn new(columns: &[&str]) -> Self {
        let names = columns.iter().map(|name| name.trim_end_matches('>'));
        Self {
            rows: vec![names.map(str::to_string).collect()],
            right: columns.iter().map(|name| name.ends_with('>')).collect(),
        }
    }

    /// Adds a row. Cells that are missing are empty.
    pub(super) fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        let mut cells: Vec<String> = cells
            .into_iter()
            .map(|cell| cell.replace('|', "\\|"))
            .collect();
        cells.resize(self.right.len(), String::new());
        self.rows.push(cells);
    }

    /// The finished table.
    pub(super) fn into_text(self) -> String {
        let widths: Vec<usize> = (0..self.right.len())
            .map(|column| {
                let cells = self.rows.iter().filter_map(|row| row.get(column));
                cells
                    .map(|cell| cell.chars().count())
                    .max()
                    .unwrap_or(0)
                    .max(2)
            })
            .collect();
        let columns = || widths.iter().zip(&self.right);
        let rule: String = columns()
            .map(|(width, right)| match right {
                true => format!("|{}:", "-".repeat(width + 1)),
                false => format!("|:{}", "-".repeat(width + 1)),
            })
            .collect();
        let mut text = String::new();
        for (index, row) in self.rows.iter().enumerate() {
            for (cell, (width, right)) in row.iter().zip(columns()) {
                text += &match right {
                    true => format!("| {cell:>width$} "),
                    false => format!("| {cell:<width$} "),
                };
            }
            text += "|\n";
            if index == 0 {
                text += &format!("{rule}|\n");
            }
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_as_wide_as_their_widest_cell() {
        let mut table = MarkdownTable::new(&["log", "error [°]>", "end"]);
        table.row(["a".into(), "1.00".into(), "x|y".into()]);
        table.row(["long-name".into()]);
        let text = table.into_text();
        assert_eq!(
            text,
            "| log       | error [°] | end  |\n\
             |:----------|----------:|:-----|\n\
             | a         |      1.00 | x\\|y |\n\
             | long-name |           |      |\n"
        );
    }
}
