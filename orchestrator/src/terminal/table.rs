//! Tables of text: columns as wide as their widest cell, two spaces between them, no trailing spaces.
//!
//! `comfy-table` measures the cells, in columns of a terminal, and wraps texts where a table would be too wide.

use comfy_table::{CellAlignment, ColumnConstraint, ContentArrangement, LineStyle, TableStyle, Width};

pub(crate) use self::Align::{Left, Right};

/// Spaces between two columns.
const GAP: u16 = 2;
/// Characters that a column of texts keeps, however narrow the terminal is.
const LEAST_TEXT: u16 = 16;

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Align {
    /// Texts, which may be wrapped.
    Left,
    /// Numbers, which may not.
    Right,
}

/// A table: its columns and its rows.
pub(crate) struct Table {
    columns: Vec<(&'static str, Align)>,
    rows: Vec<Vec<String>>,
    is_ruled: bool,
    indent: u16,
}

impl Table {
    /// A table with these columns. If all headings are empty, there is no line of headings.
    pub(crate) fn new(columns: impl Into<Vec<(&'static str, Align)>>) -> Self {
        Self { columns: columns.into(), rows: Vec::new(), is_ruled: false, indent: 0 }
    }

    /// The same with a line below the headings.
    pub(crate) fn ruled(mut self) -> Self {
        self.is_ruled = true;
        self
    }

    /// The same with so many spaces before each line.
    pub(crate) fn indented(mut self, spaces: u16) -> Self {
        self.indent = spaces;
        self
    }

    /// Adds a row, one cell for each column.
    pub(crate) fn row(&mut self, cells: impl Into<Vec<String>>) {
        let cells = cells.into();
        debug_assert_eq!(cells.len(), self.columns.len(), "a row has a cell for each column");
        self.rows.push(cells);
    }

    /// The lines for a terminal that is `width` characters wide, or as long as they are. Each ends with a newline.
    pub(crate) fn text(&self, width: Option<usize>) -> String {
        let mut grid = comfy_table::Table::new();
        let line = LineStyle::none().fill('-');
        grid.load_style(if self.is_ruled { TableStyle::new().header_separator(line) } else { TableStyle::new() });
        if let Some(width) = width.and_then(|width| u16::try_from(width).ok()) {
            grid.set_content_arrangement(ContentArrangement::Dynamic).set_width(width);
        }
        if self.columns.iter().any(|(heading, _)| !heading.is_empty()) {
            grid.set_header(self.columns.iter().map(|(heading, _)| *heading));
        }
        grid.add_rows(&self.rows);
        let widths = grid.column_max_content_widths();
        for (index, ((_, align), column)) in self.columns.iter().zip(grid.column_iter_mut()).enumerate() {
            let padding = if index == 0 { self.indent } else { GAP };
            column.set_padding((padding, 0));
            column.set_constraint(match align {
                Left => ColumnConstraint::LowerBoundary(Width::Fixed(LEAST_TEXT.min(widths[index]) + padding)),
                Right => ColumnConstraint::ContentWidth,
            });
            if *align == Right {
                column.set_cell_alignment(CellAlignment::Right);
            }
        }
        let text = grid.trim_fmt();
        if text.is_empty() { text } else { text + "\n" }
    }

    /// The same as a table of Markdown.
    pub(crate) fn markdown(&self) -> String {
        let heading =
            |(heading, _): &(&str, Align)| if heading.is_empty() { " ".into() } else { format!(" {heading} ") };
        let mut text: String = self.columns.iter().map(|column| format!("|{}", heading(column))).collect();
        text.push_str(&format!("|\n|{}\n", "---|".repeat(self.columns.len())));
        for row in &self.rows {
            text.extend(row.iter().map(|cell| format!("| {} ", cell.replace('|', "\\|"))));
            text.push_str("|\n");
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn runs() -> Table {
        let mut table = Table::new([("run", Left), ("steps", Right), ("what it was", Left)]).ruled();
        table.row(["uav".into(), "8000".into(), "a formation of six drones".to_string()]);
        table.row(["größer".into(), "20".into(), String::new()]);
        table
    }

    #[test]
    fn columns_are_as_wide_as_their_cells() {
        let expected = "\
run     steps  what it was
----------------------------------------
uav      8000  a formation of six drones
größer     20
";
        assert_eq!(runs().text(None), expected);
        assert_eq!(runs().text(Some(200)), expected);
    }

    #[test]
    fn texts_are_wrapped_in_a_narrow_terminal() {
        let text = runs().text(Some(32));
        assert!(text.lines().all(|line| line.chars().count() <= 32), "{text}");
        assert!(text.contains("\nuav      8000  a formation of\n               six drones\n"), "{text}");
        // Numbers and short texts stay whole, however narrow it is.
        assert!(runs().text(Some(3)).contains("uav      8000  a formation of\n"));
    }

    #[test]
    fn a_table_without_headings_may_be_indented() {
        let mut table = Table::new([("", Left), ("", Left)]).indented(2);
        table.row(["a", "b"].map(String::from));
        table.row(["long", "  c"].map(String::from));
        assert_eq!(table.text(None), "  a     b\n  long    c\n");
        assert_eq!(Table::new([("", Left)]).text(None), "");
    }

    #[test]
    fn markdown_keeps_its_bars_apart() {
        let mut table = Table::new([("claim", Left), ("", Left)]);
        table.row(["|x| < 1", ""].map(String::from));
        assert_eq!(table.markdown(), "| claim | |\n|---|---|\n| \\|x\\| < 1 |  |\n");
    }
}
