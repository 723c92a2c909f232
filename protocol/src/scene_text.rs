//! TOML text to a [`Scene`], with errors that name file, line and field.
//!
//! A field is named as one walks to it in the file: `ball[2].radius_m`, `floor.grid.control_heights_m[5][3]`.

use crate::scene::{SCENE_VERSION, Scene};
use std::fmt;
use std::ops::Range;
use toml_edit::{Document, Item, TableLike, Value};

/// Longest scene file.
pub const MAX_SCENE_BYTES: usize = 16 << 20;

/// What is wrong in a scene file, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneError {
    /// The file as it was named.
    pub file: String,
    /// Line and column, both from 1; none when the error is about the file as a whole.
    pub line_column: Option<[usize; 2]>,
    /// The field; empty when the error is about no single one.
    pub field: String,
    /// What is wrong, and what would be right.
    pub message: String,
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.file)?;
        if let Some([line, column]) = self.line_column {
            write!(f, ":{line}:{column}")?;
        }
        if !self.field.is_empty() {
            write!(f, ": {}", self.field)?;
        }
        write!(f, ": {}", self.message)
    }
}

impl std::error::Error for SceneError {}

/// Reads a scene of this version. What it means is for the server to check.
pub fn parse(file: &str, text: &str) -> Result<Scene, SceneError> {
    let whole =
        |message: String| SceneError { file: file.into(), line_column: None, field: String::new(), message };
    if text.len() > MAX_SCENE_BYTES {
        return Err(whole(format!("{} bytes are too many: at most {MAX_SCENE_BYTES} are read", text.len())));
    }
    let scene: Scene = toml::from_str(text).map_err(|e| SceneError {
        file: file.into(),
        line_column: e.span().map(|span| line_column(text, span.start)),
        field: e.span().map(|span| field_at(text, &span)).unwrap_or_default(),
        message: e.message().trim_end().replace('\n', " "),
    })?;
    if scene.version != SCENE_VERSION {
        let message = format!("is {}: this program reads version {SCENE_VERSION}", scene.version);
        return Err(error_at(file, text, "version", message));
    }
    Ok(scene)
}

/// An error about `field` of a file that parses, with the line where that field, or the nearest thing around it, stands.
pub fn error_at(file: &str, text: &str, field: &str, message: String) -> SceneError {
    let line_column = locate(text, field).map(|offset| line_column(text, offset));
    SceneError { file: file.into(), line_column, field: field.into(), message }
}

/// Where `field` begins, in bytes from the start of the text.
fn locate(text: &str, field: &str) -> Option<usize> {
    let document = Document::parse(text).ok()?;
    let mut place = None;
    let mut here = Node::Table(document.as_table());
    for step in steps(field) {
        let Some((start, next)) = here.enter(&step) else { break };
        place = start.or(place);
        here = next;
    }
    place
}

/// The field whose value covers `span`, as far as a walk down the document can tell.
fn field_at(text: &str, span: &Range<usize>) -> String {
    let mut field = String::new();
    let Ok(document) = Document::parse(text) else { return field };
    let mut here = Node::Table(document.as_table());
    while let Some(Child { step, node, .. }) = here.children().into_iter().find(|child| child.covers(span)) {
        match step {
            Step::Key(key) if field.is_empty() => field.push_str(&key),
            Step::Key(key) => field.extend([".", &key]),
            Step::Index(i) => field.extend(["[", &i.to_string(), "]"]),
        }
        here = node;
    }
    field
}

fn line_column(text: &str, offset: usize) -> [usize; 2] {
    let before = &text.as_bytes()[..offset.min(text.len())];
    let line = before.split(|&b| b == b'\n').count();
    let column = before.iter().rev().take_while(|&&b| b != b'\n').count() + 1;
    [line, column]
}

/// One step into a document.
#[derive(Clone, Debug, PartialEq)]
enum Step {
    Key(String),
    Index(usize),
}

/// `ball[2].uv[0]` as its steps.
fn steps(field: &str) -> impl Iterator<Item = Step> + '_ {
    field.split(['.', '[']).filter(|part| !part.is_empty()).map(|part| {
        match part.strip_suffix(']').and_then(|i| i.parse().ok()) {
            Some(i) => Step::Index(i),
            None => Step::Key(part.to_owned()),
        }
    })
}

/// Something in a document that may hold other things.
#[derive(Clone, Copy)]
enum Node<'a> {
    Table(&'a dyn TableLike),
    Tables(&'a toml_edit::ArrayOfTables),
    Value(&'a Value),
    Element(&'a toml_edit::Table),
}

impl<'a> Node<'a> {
    fn of(item: &'a Item) -> Option<Self> {
        match item {
            Item::None => None,
            Item::Value(value) => Some(Self::Value(value)),
            Item::Table(table) => Some(Self::Element(table)),
            Item::ArrayOfTables(tables) => Some(Self::Tables(tables)),
        }
    }

    fn table(self) -> Option<&'a dyn TableLike> {
        match self {
            Self::Table(table) => Some(table),
            Self::Element(table) => Some(table),
            Self::Value(value) => value.as_inline_table().map(|table| table as &dyn TableLike),
            Self::Tables(_) => None,
        }
    }

    fn span(self) -> Option<Range<usize>> {
        match self {
            Self::Table(_) => None,
            Self::Element(table) => table.span(),
            Self::Tables(tables) => tables.span(),
            Self::Value(value) => value.span(),
        }
    }

    /// The thing one step inside, and where its name or itself begins.
    fn enter(self, step: &Step) -> Option<(Option<usize>, Self)> {
        match step {
            Step::Key(key) => {
                let (key, item) = self.table()?.get_key_value(key)?;
                let node = Self::of(item)?;
                Some((key.span().or_else(|| node.span()).map(|span| span.start), node))
            }
            Step::Index(i) => {
                let node = match self {
                    Self::Tables(tables) => Self::Element(tables.get(*i)?),
                    Self::Value(value) => Self::Value(value.as_array()?.get(*i)?),
                    Self::Table(_) | Self::Element(_) => return None,
                };
                Some((node.span().map(|span| span.start), node))
            }
        }
    }

    fn children(self) -> Vec<Child<'a>> {
        let numbered = |(i, node)| Child { step: Step::Index(i), key: None, node };
        match self {
            Self::Tables(tables) => tables.iter().map(Self::Element).enumerate().map(numbered).collect(),
            Self::Value(Value::Array(array)) => {
                array.iter().map(Self::Value).enumerate().map(numbered).collect()
            }
            _ => self.table().map(named).unwrap_or_default(),
        }
    }
}

fn named(table: &dyn TableLike) -> Vec<Child<'_>> {
    let keys = table.iter().map(|(key, _)| key).collect::<Vec<_>>();
    let entry = |key| {
        let (key, item) = table.get_key_value(key)?;
        Some(Child { step: Step::Key(key.get().to_owned()), key: key.span(), node: Node::of(item)? })
    };
    keys.into_iter().filter_map(entry).collect()
}

/// Something inside a [`Node`].
struct Child<'a> {
    step: Step,
    key: Option<Range<usize>>,
    node: Node<'a>,
}

impl Child<'_> {
    /// A table's own span is only its header, so it covers what its children cover too; that of an array of tables
    /// may hold other tables between and says nothing.
    fn covers(&self, span: &Range<usize>) -> bool {
        let own = if matches!(self.node, Node::Tables(_)) { None } else { self.node.span() };
        let within = |outer: &Range<usize>| outer.start <= span.start && span.end <= outer.end;
        own.as_ref().is_some_and(within)
            || self.key.as_ref().is_some_and(within)
            || (!matches!(self.node, Node::Value(_))
                && self.node.children().iter().any(|child| child.covers(span)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = r##"version = 1
name = "two"
gravity_m_per_s2 = [0.0, 0.0, -9.81]

[floor.grid]
x_m = [-1.0, 1.0]
y_m = [-1.0, 1.0]
control_heights_m = [
    [0.0, 0.0],
    [0.0, 0.5],
]

[[ball]]
name = "a"
radius_m = 0.1
mass_kg = 1.0
center_m = [0.0, 0.0]

[[ball]]
name = "b"
radius_m = 0.1
mass_kg = 1.0
inertia = "hollow"
center_m = [0.5, 0.0]
color = "#ff0000"
"##;

    fn fault(from: &str, to: &str) -> String {
        assert!(GOOD.contains(from), "{from}");
        parse("two.toml", &GOOD.replacen(from, to, 1)).unwrap_err().to_string()
    }

    #[test]
    fn a_good_scene_is_read_and_survives_being_written() {
        let scene = parse("two.toml", GOOD).unwrap();
        assert_eq!(scene.balls.len(), 2);
        assert_eq!(parse("again", &toml::to_string(&scene).unwrap()).unwrap(), scene);
    }

    #[test]
    fn fields_are_found_by_name() {
        for (field, line) in [
            ("name", 2),
            ("gravity_m_per_s2[2]", 3),
            ("floor.grid.x_m", 6),
            ("floor.grid.control_heights_m[1][1]", 10),
            ("ball[0].radius_m", 15),
            ("ball[1]", 19),
            ("ball[1].mass_kg", 22),
            // Not written, so the ball it belongs to.
            ("ball[1].uv", 19),
        ] {
            let error = error_at("f", GOOD, field, String::new());
            assert_eq!(error.line_column.unwrap()[0], line, "{field}");
        }
        assert_eq!(error_at("f", GOOD, "cloud[0]", String::new()).line_column, None);
    }

    #[test]
    fn errors_name_line_and_field_and_what_would_be_right() {
        assert_eq!(
            fault("radius_m = 0.1\nmass_kg = 1.0\ni", "radius_m = \"big\"\nmass_kg = 1.0\ni"),
            "two.toml:21:12: ball[1].radius_m: invalid type: string \"big\", expected f64"
        );
        let unknown = fault("radius_m = 0.1", "radius = 0.1");
        assert!(unknown.starts_with("two.toml:15:1: ball[0].radius: "), "{unknown}");
        assert!(unknown.contains("unknown field `radius`, expected one of `name`, `radius_m`"), "{unknown}");
        let missing = fault("mass_kg = 1.0\n", "");
        assert!(missing.starts_with("two.toml:13:1: ball[0]: missing field `mass_kg`"), "{missing}");
        let inertia = fault("\"hollow\"", "\"heavy\"");
        assert!(
            inertia.starts_with("two.toml:23:11: ball[1].inertia: write \"solid\", \"hollow\""),
            "{inertia}"
        );
        let height = fault("[0.0, 0.5]", "[0.0, true]");
        assert!(
            height.starts_with("two.toml:10:11: floor.grid.control_heights_m[1][1]: invalid type"),
            "{height}"
        );
        let version = fault("version = 1", "version = 7");
        assert_eq!(version, "two.toml:1:1: version: is 7: this program reads version 1");
        let syntax = fault("name = \"a\"", "name = ");
        assert!(syntax.starts_with("two.toml:14:"), "{syntax}");
    }
}
