//! A Rerun recording, read back: where everything was, row by row.

use rerun::external::re_log_encoding::rrd::DecoderApp;
use rerun::log::{Chunk, LogMsg};
use rerun::{ComponentDescriptor, InstancePoses3D, Points3D, TimelineName};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// What an entity's positions were at a moment.
#[derive(Clone, Debug)]
pub struct Row {
    /// Tick since the epoch began.
    pub tick: u64,
    /// The server's clock, ns since 1970.
    pub wall_ns: u64,
    /// Positions of all instances, m.
    pub positions_m: Vec<[f32; 3]>,
}

/// A recording: each entity's rows in order of wall time.
pub struct Ride {
    entities: BTreeMap<String, Vec<Row>>,
}

impl Ride {
    /// Reads a whole file; panics where it is damaged.
    pub fn read(path: &Path) -> Self {
        let file = BufReader::new(File::open(path).unwrap_or_else(|e| panic!("{}: {e}", path.display())));
        let mut entities: BTreeMap<String, Vec<Row>> = BTreeMap::new();
        for message in DecoderApp::decode_lazy(file) {
            let LogMsg::ArrowMsg(store, arrow) = message.expect("a readable recording") else { continue };
            let chunk = Chunk::from_arrow_msg(&arrow).expect("a readable chunk");
            chunk.sanity_check().expect("a sane chunk");
            if store.is_recording() && !chunk.is_static() {
                let path = chunk.entity_path().to_string();
                for what in [InstancePoses3D::descriptor_translations(), Points3D::descriptor_positions()] {
                    entities.entry(path.clone()).or_default().extend(rows(&chunk, &what));
                }
            }
        }
        for rows in entities.values_mut() {
            rows.sort_by_key(|row| row.wall_ns);
        }
        Self { entities }
    }

    /// An entity's rows.
    pub fn rows(&self, entity: &str) -> &[Row] {
        self.entities.get(entity).map_or(&[], Vec::as_slice)
    }

    /// The rows of all entities below a path.
    pub fn rows_below<'a>(&'a self, path: &'a str) -> impl Iterator<Item = &'a Row> {
        let below = self.entities.iter().filter(move |(entity, _)| entity.starts_with(path));
        below.flat_map(|(_, rows)| rows)
    }
}

fn rows(chunk: &Chunk, what: &ComponentDescriptor) -> Vec<Row> {
    let times = |name: &'static str| {
        let indices = chunk.iter_component_indices(TimelineName::from_static_str(name), what.component);
        indices.map(|(time, _)| u64::try_from(time.as_i64()).expect("a time since the beginning"))
    };
    let positions = chunk.iter_slices::<[f32; 3]>(what.component);
    times("tick")
        .zip(times("wall_time"))
        .zip(positions)
        .map(|((tick, wall_ns), positions)| Row { tick, wall_ns, positions_m: positions.to_vec() })
        .collect()
}
