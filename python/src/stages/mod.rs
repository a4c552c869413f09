//! Stages written in Python: any callable on arrays.
//!
//! A kind builds its stage from settings alone, so callables are kept in a table by a key, and a kind reads its key.

mod affinity;
mod kmeans;
mod spectral;

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crosscut::Kinds;
use crosscut_detector::Registry;
use crosscut_stage::{Kind, ParamSpec, Params, Shape, StageError, StageKind, Word};
use pyo3::exceptions::{PyAttributeError, PyImportError};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

pub(crate) use self::affinity::KIND as AFFINITY;
use self::kmeans::KIND as KMEANS;
use self::spectral::KIND as SPECTRAL;

const CALLABLE: Word = Word::any("callable", "").doc("the callable, as the package numbers it or module.name");

/// Callables by key. While it is locked, nothing of Python is made, called or dropped: an object that goes may own an engine,
/// whose callables leave the table too.
static TABLE: Mutex<BTreeMap<String, Callable>> = Mutex::new(BTreeMap::new());

fn table() -> MutexGuard<'static, BTreeMap<String, Callable>> {
    TABLE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The key of a callable, which is in the table until this is dropped.
pub(crate) struct Entry {
    key: String,
}

impl Entry {
    /// Of a callable of no engine.
    pub(crate) fn of(function: Bound<'_, PyAny>) -> Self {
        Self::numbered(Callable::new(function, &Arc::default()))
    }

    /// Under a key that no other has.
    fn numbered(callable: Callable) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self::new(NEXT.fetch_add(1, Ordering::Relaxed).to_string(), callable)
    }

    fn new(key: String, callable: Callable) -> Self {
        let replaced = table().insert(key.clone(), callable);
        drop(replaced);
        Self { key }
    }

    pub(crate) fn key(&self) -> &str {
        &self.key
    }
}

impl Drop for Entry {
    fn drop(&mut self) {
        let removed = table().remove(&self.key);
        drop(removed);
    }
}

/// A callable, and the exception that it raised last.
#[derive(Clone)]
struct Callable {
    function: Arc<Py<PyAny>>,
    /// `module.name`, for messages.
    name: String,
    raised: Arc<Mutex<Option<PyErr>>>,
}

impl Callable {
    fn new(function: Bound<'_, PyAny>, raised: &Arc<Mutex<Option<PyErr>>>) -> Self {
        let part = |attribute| function.getattr(attribute).map(|part| part.to_string());
        let name = match (part("__module__"), part("__qualname__")) {
            (Ok(module), Ok(name)) => format!("{module}.{name}"),
            _ => function.get_type().to_string(),
        };
        Self { function: Arc::new(function.unbind()), name, raised: Arc::clone(raised) }
    }

    /// That which the settings name.
    fn chosen(params: &Params) -> Option<Self> {
        table().get(&params.get(CALLABLE)).cloned()
    }

    /// Calls it; `read` takes what it returned. An exception of either is kept, and the error names its type and text.
    fn call<T>(
        chosen: Option<&Self>,
        args: impl for<'py> FnOnce(Python<'py>) -> PyResult<Bound<'py, PyTuple>>,
        read: impl FnOnce(&Bound<'_, PyAny>) -> PyResult<T>,
    ) -> Result<T, StageError> {
        let this = chosen.ok_or_else(|| StageError::Unsupported("there is no callable of this name".to_owned()))?;
        Python::attach(|py| {
            let keep = |error| {
                let replaced = this.raised.lock().unwrap_or_else(PoisonError::into_inner).replace(error);
                drop(replaced);
            };
            let returned = args(py).and_then(|args| this.function.bind(py).call1(args)).map_err(|error| {
                let text = StageError::Unsupported(format!("{} raised {error}", this.name));
                keep(error);
                text
            })?;
            read(&returned).map_err(|error| {
                let text = Self::refuse(chosen, format_args!("what cannot be read: {}", error.value(py)));
                keep(error);
                text
            })
        })
    }

    /// What the callable returned and should not have.
    fn refuse(chosen: Option<&Self>, what: impl std::fmt::Display) -> StageError {
        StageError::Mismatch(format!("{} returned {what}", chosen.map_or("the callable", |this| &this.name)))
    }
}

/// The callables of one engine. They leave the table with it.
#[derive(Default)]
pub(crate) struct Callables {
    /// Section of the configuration, and callable.
    chosen: Vec<(&'static str, Entry)>,
    raised: Arc<Mutex<Option<PyErr>>>,
}

impl Callables {
    /// Those for the affinity, spectral and kmeans stage. Adds their kinds to `registry`.
    pub(crate) fn new(py: Python<'_>, stages: [Option<Py<PyAny>>; 3], registry: &mut Registry) -> PyResult<Self> {
        let mut this = Self::default();
        for (section, function) in ["affinity", "spectral", "kmeans"].into_iter().zip(stages) {
            let Some(function) = function else { continue };
            match section {
                "affinity" => registry.affinity.push(AFFINITY),
                "spectral" => registry.spectral.push(SPECTRAL),
                _ => registry.kmeans.push(KMEANS),
            }
            let callable = Callable::new(function.into_bound(py), &this.raised);
            this.chosen.push((section, Entry::numbered(callable)));
        }
        Ok(this)
    }

    /// The settings that choose them.
    pub(crate) fn settings(&self) -> impl Iterator<Item = String> {
        let setting = |(section, entry): &(&str, Entry)| {
            [format!("{section}.kind={PYTHON}"), format!("{section}.callable=\"{}\"", entry.key())]
        };
        self.chosen.iter().flat_map(setting)
    }

    /// The exception that one of them raised since the last call.
    pub(crate) fn raised(&self) -> Option<PyErr> {
        self.raised.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

/// The kind of a callable that was given as an object.
const PYTHON: &str = "python";

/// Callables that are named on the command line, or at a prompt.
pub(crate) struct Found {
    /// `find(name)` gives the callable of `python:module.name`, and how often its code has changed.
    find: Py<PyAny>,
    /// What one of them raised last.
    raised: Arc<Mutex<Option<PyErr>>>,
}

impl Found {
    pub(crate) fn by(find: Py<PyAny>) -> Self {
        Self { find, raised: Arc::default() }
    }

    /// Adds `function` as a kind of this name to every stage, for the rest of the process.
    pub(crate) fn add(&self, name: &str, function: Bound<'_, PyAny>, registry: &mut Registry) {
        add_named(name, Callable::new(function, &self.raised), registry);
    }
}

impl Kinds for Found {
    fn find(&self, kind: &str, registry: &mut Registry) -> Result<Option<String>, String> {
        if !kind.starts_with("python:") {
            return Ok(None);
        }
        Python::attach(|py| {
            let found = self.find.bind(py).call1((kind,));
            let found = found.and_then(|found| found.extract::<(Bound<'_, PyAny>, u32)>());
            let (function, changes) = found.map_err(|error| {
                let is_plain =
                    error.is_instance_of::<PyImportError>(py) || error.is_instance_of::<PyAttributeError>(py);
                let place = if is_plain { String::new() } else { traceback(py, &error) };
                format!("there is no stage {kind}: {error}{place}")
            })?;
            let name = if changes == 0 { kind.to_owned() } else { format!("{kind}#{}", changes + 1) };
            if !registry.affinity.iter().any(|known| known.name == name) {
                self.add(&name, function, registry);
            }
            Ok(Some(name))
        })
    }

    fn failed(&self) -> Option<String> {
        let raised = self.raised.lock().unwrap_or_else(PoisonError::into_inner).take()?;
        Python::attach(|py| Some(format!("{}{raised}", traceback(py, &raised).trim_start())))
    }
}

/// The traceback of an exception, on lines of its own.
fn traceback(py: Python<'_>, error: &PyErr) -> String {
    let text = error.traceback(py).and_then(|traceback| traceback.format().ok());
    text.map_or_else(String::new, |text| format!("\n{text}"))
}

/// Adds a callable as a kind of this name to every stage, for the rest of the process.
fn add_named(name: &str, callable: Callable, registry: &mut Registry) {
    let entry = Entry::new(name.to_owned(), callable);
    registry.affinity.push(named(AFFINITY, name, &entry));
    registry.spectral.push(named(SPECTRAL, name, &entry));
    registry.kmeans.push(named(KMEANS, name, &entry));
    std::mem::forget(entry);
}

/// The kind of this name that calls what is in the table.
pub(crate) fn named<S: StageKind + ?Sized>(mut kind: Kind<S>, name: &str, entry: &Entry) -> Kind<S> {
    let leaked = |text: &str| -> &'static str { Box::leak(text.to_owned().into_boxed_str()) };
    let spec = ParamSpec { shape: Shape::Text { default: leaked(entry.key()) }, ..CALLABLE.spec };
    kind.name = leaked(name);
    kind.params = Box::leak(Box::new([spec]));
    kind
}
