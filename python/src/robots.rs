//! Live robots, which Python hears and answers: its packages for their networks take seconds to install.

use crosscut::{Answer, Robot, RobotAddress, RobotError, Robots};
use crosscut_ingest::Feed as Messages;
use pyo3::exceptions::{PyImportError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

/// Takes the messages of a robot.
#[pyclass(frozen, module = "crosscut._native")]
pub(crate) struct Feed(Messages);

#[pymethods]
impl Feed {
    /// Takes a message in CDR, and how many of its topic are missing before it. False: nobody wants any more.
    fn hear(&self, topic: &str, message_type: &str, message: &[u8], missing: u64) -> bool {
        self.0.hear(topic, message_type, message.to_vec(), missing).is_ok()
    }

    /// The robot can no longer be heard.
    fn fail(&self, why: String) -> bool {
        self.0.fail(why).is_ok()
    }
}

/// Hears robots by a function of Python: `hear(address, options, feed)` gives an object with `send` and `close`.
pub(crate) struct Heard(pub(crate) Py<PyAny>);

impl Robots for Heard {
    fn hear(&self, robot: &RobotAddress, feed: Messages) -> Result<Box<dyn Robot>, RobotError> {
        Python::attach(|py| {
            let robot = options(py, robot).and_then(|options| {
                let feed = Bound::new(py, Feed(feed))?;
                self.0.call1(py, (&robot.address, options, feed))
            });
            match robot {
                Ok(robot) => Ok(Box::new(Talking(robot)) as Box<dyn Robot>),
                Err(error) => Err(refused(py, &error)),
            }
        })
    }
}

fn options<'py>(py: Python<'py>, robot: &RobotAddress) -> PyResult<Bound<'py, PyDict>> {
    let options = PyDict::new(py);
    options.set_item("topic", &robot.topic)?;
    options.set_item("beside", &robot.beside)?;
    options.set_item("message_type", &robot.message_type)?;
    options.set_item("publish", &robot.publish)?;
    Ok(options)
}

/// Wrong settings and missing packages are wrong usage.
fn refused(py: Python<'_>, error: &PyErr) -> RobotError {
    let text = error.value(py).to_string();
    if error.is_instance_of::<PyValueError>(py) || error.is_instance_of::<PyImportError>(py) {
        RobotError::Usage(text)
    } else {
        RobotError::Failed(text)
    }
}

/// A robot that is heard.
struct Talking(Py<PyAny>);

impl Robot for Talking {
    fn send(&mut self, answer: Answer<'_>) -> Result<(), String> {
        Python::attach(|py| {
            let sent = match answer {
                Answer::Results(text) => self.0.call_method1(py, "send", ("results", text)),
                Answer::Map(text) => self.0.call_method1(py, "send", ("map", text)),
                Answer::Markers(message) => self.0.call_method1(py, "send", ("markers", PyBytes::new(py, message))),
            };
            sent.map(drop).map_err(|error| error.value(py).to_string())
        })
    }
}

impl Drop for Talking {
    fn drop(&mut self) {
        // What cannot be closed is gone.
        Python::attach(|py| self.0.call_method0(py, "close").ok());
    }
}
