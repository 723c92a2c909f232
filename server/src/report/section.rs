//! A part of the page.

use maud::{Markup, html};
use serde_json::Value;

/// A part of the page: what people read, and the same numbers for programs.
#[derive(Clone, Debug)]
pub struct Section {
    /// Its anchor on the page and its key in the JSON, `[a-z0-9-]`.
    pub id: String,
    /// Its heading.
    pub title: String,
    /// One sentence for the top of the page, as a fragment of HTML; empty if it has nothing to say there.
    pub summary: String,
    /// A fragment of HTML: prose, tables, inline SVG.
    pub html: String,
    /// Its numbers, written as CSV. Tables of one name from several sections become one file.
    pub tables: Vec<Table>,
    /// Its numbers as JSON.
    pub json: Value,
    /// Pictures that are also written as files: name without ending, and SVG.
    pub pictures: Vec<(String, String)>,
}

impl Section {
    /// An empty one.
    pub fn new(id: impl Into<String>, title: impl Into<String>) -> Self {
        Self {
            id: id.into(),
            title: title.into(),
            summary: String::new(),
            html: String::new(),
            tables: Vec::new(),
            json: Value::Null,
            pictures: Vec::new(),
        }
    }
}

/// A table of numbers and words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Table {
    /// Name of its file, without `.csv`.
    pub name: String,
    /// What stands above the columns, with units.
    pub header: Vec<String>,
    /// A cell a column.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// An empty one.
    pub fn new(name: impl Into<String>, header: &[&str]) -> Self {
        Self { name: name.into(), header: header.iter().map(|&h| h.to_owned()).collect(), rows: Vec::new() }
    }

    /// One row more.
    pub fn push<const N: usize>(&mut self, row: [String; N]) {
        assert_eq!(N, self.header.len(), "{}: a cell a column", self.name);
        self.rows.push(row.into());
    }
}

/// A table as people read it. Cells that begin like numbers are set to the right.
pub fn table(header: &[&str], rows: &[Vec<String>]) -> Markup {
    let of_numbers =
        |column: usize| rows.first().and_then(|row| row.get(column)).is_some_and(|cell| is_number(cell));
    html! {
        div class="wide" {
            table {
                thead {
                    tr {
                        @for (i, head) in header.iter().enumerate() {
                            th class=[of_numbers(i).then_some("n")] { (head) }
                        }
                    }
                }
                tbody {
                    @for row in rows {
                        tr { @for cell in row { td class=[is_number(cell).then_some("n")] { (cell) } } }
                    }
                }
            }
        }
    }
}

/// A picture with its caption.
pub fn figure(svg: &str, caption: &Markup) -> Markup {
    html! { figure { (maud::PreEscaped(svg)) figcaption { (caption) } } }
}

fn is_number(cell: &str) -> bool {
    let mut letters = cell.trim_start_matches(['−', '-', '+', '≥', '≤', '<', '>', '~', ' ']).chars();
    letters.next().is_some_and(|first| first.is_ascii_digit() || first == '∞' || first == '–')
}
