//! A real Rerun viewer without a window: asked over its own control service what it holds, and for pictures.

use crate::process::Process;
use crate::wait::{PATIENCE, until, within};
use re_protos::sdk_comms::v1alpha1::viewer_control_service_client::ViewerControlServiceClient;
use re_protos::sdk_comms::v1alpha1::{GetViewerStateRequest, SaveScreenshotRequest};
use std::collections::BTreeMap;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;
use tempfile::TempDir;
use tokio::runtime::Runtime;
use tonic::transport::Channel;

/// The version that the bridge is built for.
const VERSION: &str = "0.36.3";
/// Set where a missing viewer is a failure, not a reason to skip.
const REQUIRED: &str = "BALLROOM_REQUIRE_VIEWER";
/// Mesa's software Vulkan, where it is installed: the same pixels on every machine.
const SOFTWARE_VULKAN: &str = "/usr/share/vulkan/icd.d";
/// A first picture in software takes seconds on a busy machine.
const SLOW: Duration = Duration::from_mins(3);

/// A viewer's process.
pub struct Screen {
    /// Ends with this.
    _process: Process,
    runtime: Runtime,
    control: ViewerControlServiceClient<Channel>,
    directory: TempDir,
}

impl Screen {
    /// Starts a viewer on what is served at `url`. Says why and gives none where no viewer can run.
    pub fn watching(url: &str) -> Option<Self> {
        match Self::start(url) {
            Ok(screen) => Some(screen),
            Err(why) if std::env::var_os(REQUIRED).is_some() => panic!("{REQUIRED} is set, but {why}"),
            Err(why) => {
                println!("SKIPPED: {why}; with {REQUIRED}=1 this is a failure");
                None
            }
        }
    }

    fn start(url: &str) -> Result<Self, String> {
        let program = program()?;
        let directory = tempfile::tempdir().map_err(|e| e.to_string())?;
        let port = free_port();
        let mut command = Command::new(&program);
        command
            .args([url, "--headless", "--bind", "127.0.0.1", "--port", &port.to_string()])
            .args(["--window-size", "1100x650"])
            .env("XDG_RUNTIME_DIR", directory.path())
            .env("XDG_DATA_HOME", directory.path())
            .env("XDG_CONFIG_HOME", directory.path());
        if let Some(driver) = software_vulkan() {
            command.env("VK_ICD_FILENAMES", driver);
        }
        let mut process = Process::spawn("a headless viewer".into(), command);
        let runtime =
            tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(|e| e.to_string())?;
        let connect = || {
            let endpoint = tonic::transport::Endpoint::from_shared(format!("http://127.0.0.1:{port}"));
            runtime.block_on(endpoint.expect("an address").connect()).ok()
        };
        let mut channel = None;
        within(SLOW, || {
            channel = connect();
            (channel.is_some() || process.has_ended()).then_some(())
        });
        let channel = channel.ok_or_else(|| {
            let words = process.words();
            format!("the viewer {} does not run here:\n{words}", program.display())
        })?;
        Ok(Self { _process: process, runtime, control: ViewerControlServiceClient::new(channel), directory })
    }

    /// The last time on each timeline of the recordings it holds; none before it holds one.
    pub fn newest(&mut self) -> BTreeMap<String, i64> {
        let asked = self.runtime.block_on(self.control.get_viewer_state(GetViewerStateRequest {}));
        let Ok(state) = asked else { return BTreeMap::new() };
        let timelines = state.into_inner().recordings.into_iter().flat_map(|recording| recording.timelines);
        timelines.filter_map(|timeline| Some((timeline.timeline?.name, timeline.time_range?.end))).collect()
    }

    /// A picture of one view, by its entity in the layout: `/view/ID`.
    pub fn picture(&mut self, view: &str) -> Picture {
        let path = self.directory.path().join("picture.png");
        let id = view.trim_start_matches("/view/").to_owned();
        let request =
            SaveScreenshotRequest { view_id: Some(id), file_path: path.to_str().expect("UTF-8").into() };
        until("a picture", SLOW, || {
            let asked = self.runtime.block_on(self.control.save_screenshot(request.clone()));
            asked.map_err(|fault| println!("no picture yet: {}", fault.message())).ok()
        });
        Picture::read(&path)
    }
}

/// Rerun's viewer of the right version in the path; what pip installs as `rerun` is a script beside the program.
fn program() -> Result<PathBuf, String> {
    let missing = || format!("no rerun {VERSION} is in the path (`pip install rerun-sdk=={VERSION}`)");
    let path = std::env::var_os("PATH").ok_or_else(missing)?;
    let installed = std::env::split_paths(&path).filter(|directory| directory.join("rerun").exists());
    let program = |directory: PathBuf| {
        let library = directory.join("../lib");
        let pythons = std::fs::read_dir(library).into_iter().flatten().flatten().map(|entry| entry.path());
        let wheel = |python: PathBuf| python.join("site-packages/rerun_sdk/rerun_cli/rerun");
        let mut wheels = pythons.map(wheel).filter(|wheel| wheel.exists());
        wheels.next().unwrap_or_else(|| directory.join("rerun"))
    };
    installed.map(program).find(|program| version(program).as_deref() == Some(VERSION)).ok_or_else(missing)
}

fn version(program: &Path) -> Option<String> {
    let output = Command::new(program).arg("--version").stdin(Stdio::null()).output().ok()?;
    let words = String::from_utf8_lossy(&output.stdout).into_owned();
    words.split_whitespace().skip_while(|word| *word != "rerun-cli").nth(1).map(str::to_owned)
}

fn software_vulkan() -> Option<PathBuf> {
    let drivers = std::fs::read_dir(SOFTWARE_VULKAN).ok()?.flatten().map(|entry| entry.path());
    let name =
        |path: &PathBuf| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("lvp"));
    drivers.into_iter().find(name)
}

fn free_port() -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    listener.local_addr().expect("an address").port()
}

/// Pixels, row by row from the top.
pub struct Picture {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    rgb: Vec<[u8; 3]>,
}

impl Picture {
    fn read(path: &Path) -> Self {
        // The answer may come before the last byte is on disk.
        until("a whole picture", PATIENCE, || Self::decoded(path))
    }

    fn decoded(path: &Path) -> Option<Self> {
        let file = std::io::BufReader::new(std::fs::File::open(path).ok()?);
        let mut reader = png::Decoder::new(file).read_info().ok()?;
        let mut bytes = vec![0; reader.output_buffer_size()?];
        let frame = reader.next_frame(&mut bytes).ok()?;
        let samples = frame.color_type.samples();
        let pixel = |pixel: &[u8]| [pixel[0], pixel[1], pixel[2]];
        assert!(samples >= 3 && frame.bit_depth == png::BitDepth::Eight, "{:?}", frame.color_type);
        let rgb = bytes[..frame.buffer_size()].chunks_exact(samples).map(pixel).collect();
        Some(Self { width: frame.width as usize, height: frame.height as usize, rgb })
    }

    /// Which part of a disc has about the hue of a colour, 0 to 1: shades of it count, grey does not.
    pub fn share_of(&self, color: [u8; 3], [x, y]: [f64; 2], radius: f64) -> f64 {
        let (mut inside, mut alike) = (0, 0);
        for row in 0..self.height {
            for column in 0..self.width {
                if f64::hypot(column as f64 - x, row as f64 - y) <= radius {
                    inside += 1;
                    alike += u32::from(same_hue(self.rgb[row * self.width + column], color));
                }
            }
        }
        f64::from(alike) / f64::from(inside.max(1))
    }
}

/// Both are strong colours, and without their common grey they point in the same direction.
fn same_hue(a: [u8; 3], b: [u8; 3]) -> bool {
    let [(a, a_is_strong), (b, b_is_strong)] = [a, b].map(|color| {
        let [least, most] =
            [color.into_iter().min(), color.into_iter().max()].map(|c| f64::from(c.unwrap_or(0)));
        (color.map(|channel| f64::from(channel) - least), most > 40.0 && most - least > 0.5 * most)
    });
    let dot = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    a_is_strong && b_is_strong && dot(a, b) > 0.97 * (dot(a, a) * dot(b, b)).sqrt()
}
