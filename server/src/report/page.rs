//! Sections to a folder: a page, a file of CSV a table, and all numbers as JSON.

use super::machine::Machine;
use super::section::{Section, Table};
use super::{Options, ReportError, clock};
use maud::{DOCTYPE, Markup, PreEscaped, html};
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};

/// Version of the JSON's layout, under the key [`MARK`].
const LAYOUT: u32 = 1;
/// The key by which a folder is known as a report.
const MARK: &str = "ballroom_report";

/// A report being put together.
#[derive(Clone, Debug)]
pub struct Page {
    options: Options,
    machine: Machine,
    sections: Vec<Section>,
}

impl Page {
    /// An empty one. Refused if the folder is there and holds anything but a report; nothing is written yet.
    pub fn begin(options: &Options) -> Result<Self, ReportError> {
        let fresh = match std::fs::read_dir(&options.out) {
            Ok(mut entries) => entries.next().is_none(),
            Err(_) => !options.out.exists(),
        };
        if !fresh && !is_report(&options.out) {
            return Err(ReportError::NotAReport(options.out.clone()));
        }
        Ok(Self { options: options.clone(), machine: Machine::here(), sections: Vec::new() })
    }

    /// Adds sections at the end.
    pub fn add(&mut self, sections: impl IntoIterator<Item = Section>) {
        self.sections.extend(sections);
    }

    /// Writes `index.html`, `report.json`, a file of CSV a table and the pictures, and returns the page's path.
    pub fn write(&self) -> Result<PathBuf, ReportError> {
        let out = &self.options.out;
        let failed = |path: &Path| {
            let path = path.to_owned();
            move |why| ReportError::Write { path, why }
        };
        let put = |name: &str, bytes: &[u8]| {
            let path = out.join(name);
            std::fs::write(&path, bytes).map_err(failed(&path))
        };
        std::fs::create_dir_all(out).map_err(failed(out))?;
        for table in merged(&self.sections)? {
            put(&format!("{}.csv", table.name), &csv_of(&table))?;
        }
        for (name, svg) in self.sections.iter().flat_map(|section| &section.pictures) {
            put(&format!("{name}.svg"), svg.as_bytes())?;
        }
        put("report.json", format!("{:#}\n", self.json()).as_bytes())?;
        put("index.html", self.html().into_string().as_bytes())?;
        Ok(out.join("index.html"))
    }

    fn json(&self) -> Value {
        let sections: Map<_, _> = self.sections.iter().map(|s| (s.id.clone(), s.json.clone())).collect();
        json!({
            MARK: LAYOUT,
            "command": self.options.command,
            "quick": self.options.quick,
            "machine": self.machine,
            "cpu": clock::HOW,
            "sections": sections,
        })
    }

    fn html(&self) -> Markup {
        let summaries = self.sections.iter().filter(|section| !section.summary.is_empty());
        html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    title { "Speed against error" }
                    style { (PreEscaped(include_str!("page.css"))) }
                }
                body {
                    h1 { "Speed against error" }
                    p class="lead" { "What Ballroom’s engine costs, and how exact it is for that." }
                    div class="summary" {
                        ul { @for section in summaries { li { (PreEscaped(&section.summary)) } } }
                        nav {
                            @for section in &self.sections { a href={ "#" (section.id) } { (section.title) } " " }
                        }
                    }
                    (self.facts())
                    @for section in &self.sections {
                        section id=(section.id) { h2 { (section.title) } (PreEscaped(&section.html)) }
                    }
                }
            }
        }
    }

    /// What it was measured on, and how.
    fn facts(&self) -> Markup {
        let Machine { processor, threads, system, load, version, build } = &self.machine;
        html! {
            h3 { "How this was measured" }
            dl class="facts" {
                dt { "command" } dd { code { (self.options.command) } }
                dt { "program" } dd { "ballroom " (version) ", " (build) }
                dt { "machine" } dd { (processor) ", " (threads) " threads, " (system) }
                @if let Some(load) = load { dt { "load at the start" } dd { (load) } }
                dt { "CPU time" } dd { (clock::HOW) }
                dt { "numbers" } dd { a href="report.json" { "report.json" } ", and CSV files beside this page" }
            }
        }
    }
}

fn is_report(folder: &Path) -> bool {
    let text = std::fs::read(folder.join("report.json")).unwrap_or_default();
    serde_json::from_slice::<Value>(&text).is_ok_and(|value| value.get(MARK).is_some())
}

/// Tables of one name put under one another, in order of their first sections.
fn merged(sections: &[Section]) -> Result<Vec<Table>, ReportError> {
    let mut tables: Vec<Table> = Vec::new();
    for table in sections.iter().flat_map(|section| &section.tables) {
        match tables.iter_mut().find(|known| known.name == table.name) {
            Some(known) if known.header == table.header => known.rows.extend(table.rows.iter().cloned()),
            Some(_) => return Err(ReportError::Columns(table.name.clone())),
            None => tables.push(table.clone()),
        }
    }
    Ok(tables)
}

fn csv_of(table: &Table) -> Vec<u8> {
    let mut bytes = csv::Writer::from_writer(Vec::new());
    let rows = std::iter::once(&table.header).chain(&table.rows);
    // Into memory, and with as many cells a row as columns, this cannot fail.
    rows.for_each(|row| bytes.write_record(row).expect("a cell a column"));
    bytes.into_inner().expect("memory takes all")
}
