//! Properties of views: 2D bounds, eyes, axes, legends. The blueprint has no setters for them, so each is logged beside
//! its view, and all messages are sent together.

use rerun::blueprint::{Blueprint, BlueprintActivation, ContainerLike};
use rerun::external::re_log_types::{ApplicationId, BlueprintActivationCommand};
use rerun::log::LogMsg;
use rerun::{AsComponents, RecordingStream, RecordingStreamBuilder, RecordingStreamResult, StoreKind};

struct Property {
    path: String,
    value: Box<dyn AsComponents>,
}

/// The properties of the views of a layout.
#[derive(Default)]
pub(super) struct Properties(Vec<Property>);

impl Properties {
    /// Adds a property of `view`, and returns the view.
    pub(super) fn with(
        &mut self,
        view: impl Into<ContainerLike>,
        name: &str,
        value: impl AsComponents + 'static,
    ) -> ContainerLike {
        let view = view.into();
        if let ContainerLike::View(view) = &view {
            let path = format!("{}/{name}", view.blueprint_path().to_string().trim_start_matches('/'));
            self.0.push(Property { path, value: Box::new(value) });
        }
        view
    }

    /// The properties of both.
    pub(super) fn and(mut self, others: Self) -> Self {
        self.0.extend(others.0);
        self
    }
}

/// Sends the layout and makes it the active one.
pub(super) fn send(rec: &RecordingStream, layout: &Blueprint, properties: Properties) -> RecordingStreamResult<()> {
    let application = rec.store_info().map(|info| info.application_id().clone());
    let (mut messages, command) = messages_of(layout, application.unwrap_or_else(|| "crosscut".into()))?;
    messages.extend(property_messages(&command, properties)?);
    rec.send_blueprint(messages, command);
    Ok(())
}

/// The messages of a layout for all recordings of an application.
fn messages_of(
    layout: &Blueprint,
    application: ApplicationId,
) -> RecordingStreamResult<(Vec<LogMsg>, BlueprintActivationCommand)> {
    let (scratch, storage) = RecordingStreamBuilder::new(application).send_properties(false).memory()?;
    layout.send(&scratch, BlueprintActivation::default())?;
    let mut messages = storage.take();
    messages.retain(|message| message.store_id().kind() == StoreKind::Blueprint);
    let command = messages.iter().rev().find_map(|message| match message {
        LogMsg::BlueprintActivationCommand(command) => Some(command.clone()),
        _ => None,
    });
    let command = command.expect("a blueprint that was sent ends with its activation");
    messages.retain(|message| !matches!(message, LogMsg::BlueprintActivationCommand(_)));
    Ok((messages, command))
}

fn property_messages(
    command: &BlueprintActivationCommand,
    properties: Properties,
) -> RecordingStreamResult<Vec<LogMsg>> {
    let (scratch, storage) =
        RecordingStreamBuilder::from_store_id(&command.blueprint_id).send_properties(false).memory()?;
    scratch.set_time_sequence("blueprint", 0);
    for Property { path, value } in properties.0 {
        scratch.log(path, &*value)?;
    }
    let mut messages = storage.take();
    messages.retain(|message| matches!(message, LogMsg::ArrowMsg(..)));
    Ok(messages)
}
