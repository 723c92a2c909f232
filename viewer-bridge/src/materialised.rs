//! A blueprint as messages: Rerun's builder has no setters for the eye, the background, what is hidden and plots'
//! time ranges, so these are appended to the same store.

use rerun::blueprint::{Blueprint, BlueprintActivation};
use rerun::external::re_log_types::{ApplicationId, BlueprintActivationCommand};
use rerun::external::re_sdk_types::blueprint::archetypes::{ContainerBlueprint, ViewBlueprint};
use rerun::log::{Chunk, LogMsg};
use rerun::{AsComponents, ComponentDescriptor, RecordingStream, RecordingStreamBuilder};
use rerun::{RecordingStreamResult, StoreId};

/// A blueprint as messages, to which more is added.
pub struct Materialised {
    store: StoreId,
    messages: Vec<LogMsg>,
    activation: BlueprintActivationCommand,
    parts: Vec<Part>,
}

/// A view or a container.
#[derive(Clone, Debug, Default)]
pub struct Part {
    /// Its entity in the blueprint.
    pub path: String,
    /// What kind of view; empty for a container.
    pub class: String,
    /// What stands on its tab.
    pub title: String,
}

impl Materialised {
    /// Turns a blueprint for an application into messages; None where it comes out empty.
    pub fn of(
        application: ApplicationId,
        blueprint: &Blueprint,
        activation: BlueprintActivation,
    ) -> RecordingStreamResult<Option<Self>> {
        let (scratch, storage) = RecordingStreamBuilder::new(application).memory()?;
        blueprint.send(&scratch, activation)?;
        flush(&scratch);
        Ok(Self::sorted(storage.take()))
    }

    fn sorted(stream: Vec<LogMsg>) -> Option<Self> {
        let (mut messages, mut activation, mut store, mut parts) = (vec![], None, None, vec![]);
        for message in stream {
            match &message {
                LogMsg::BlueprintActivationCommand(command) => {
                    activation = Some(command.clone());
                    continue;
                }
                LogMsg::SetStoreInfo(info) if info.info.store_id.is_blueprint() => {
                    store = Some(info.info.store_id.clone());
                }
                LogMsg::ArrowMsg(id, arrow) if id.is_blueprint() => {
                    parts.extend(part(&Chunk::from_arrow_msg(arrow).ok()?));
                }
                _ => continue,
            }
            messages.push(message);
        }
        Some(Self { store: store?, messages, activation: activation?, parts })
    }

    /// Its views and containers.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// Adds properties: entities of the blueprint and what they hold.
    pub fn add(&mut self, properties: &[(String, &dyn AsComponents)]) -> RecordingStreamResult<()> {
        let (stream, storage) = RecordingStreamBuilder::from_store_id(&self.store).blueprint().memory()?;
        stream.set_time_sequence("blueprint", 0);
        for (path, property) in properties {
            stream.log(path.as_str(), *property)?;
        }
        flush(&stream);
        let added = storage.take().into_iter();
        self.messages.extend(added.filter(|m| matches!(m, LogMsg::ArrowMsg(id, _) if id.is_blueprint())));
        Ok(())
    }

    /// What is to be sent.
    pub fn into_messages(self) -> (Vec<LogMsg>, BlueprintActivationCommand) {
        (self.messages, self.activation)
    }
}

fn part(chunk: &Chunk) -> Option<Part> {
    let path = chunk.entity_path().to_string();
    let text = |descriptor: ComponentDescriptor| {
        let first = chunk.iter_slices::<String>(descriptor.component).flatten().next();
        first.map(|text| text.to_string()).unwrap_or_default()
    };
    let (class, title) = match path.split('/').collect::<Vec<_>>()[..] {
        ["", "view", _] => (
            text(ViewBlueprint::descriptor_class_identifier()),
            text(ViewBlueprint::descriptor_display_name()),
        ),
        ["", "container", _] => (String::new(), text(ContainerBlueprint::descriptor_display_name())),
        _ => return None,
    };
    Some(Part { path, class, title })
}

/// Memory sinks cannot stall, so a failure is one of encoding; the layout then lacks a part, nothing else.
fn flush(stream: &RecordingStream) {
    if let Err(fault) = stream.flush_blocking() {
        tracing::warn!("the viewer's layout is incomplete: {fault}");
    }
}
