//! Computing without the interpreter, so that other Python threads run meanwhile and Ctrl-C is heard.

use std::{
    any::Any,
    panic::{AssertUnwindSafe, catch_unwind, resume_unwind},
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicUsize, Ordering},
        mpsc::{self, RecvTimeoutError},
    },
    time::Duration,
};

use mlr_filter::SettingError;
use mlr_ga::most_threads;
use pyo3::{Py, PyAny, PyResult, Python, exceptions::PyRuntimeError, types::PyAnyMethods};
use rayon::ThreadPoolBuilder;

use crate::failure::exception;

/// How often signals are looked for and progress is told.
const POLL: Duration = Duration::from_millis(50);

/// How long a computation takes, and where it is.
#[derive(Debug, Default)]
pub(crate) struct Steps {
    expected: AtomicUsize,
    done: AtomicUsize,
    is_given_up: AtomicBool,
}

/// What unwinds a computation that nobody waits for any more.
struct GivenUp;

impl Steps {
    /// Unwinds a computation that was given up. No panic: nothing is wrong.
    fn go_on(&self) {
        if self.is_given_up.load(Ordering::Relaxed) {
            resume_unwind(Box::new(GivenUp));
        }
    }
}

impl mlr_ga::Progress for Steps {
    fn expect(&self, candidates: usize) {
        self.go_on();
        self.expected.store(candidates, Ordering::Relaxed);
    }

    fn expect_more(&self, candidates: usize) {
        self.go_on();
        self.expected.fetch_add(candidates, Ordering::Relaxed);
    }

    fn advance(&self) {
        self.go_on();
        self.done.fetch_add(1, Ordering::Relaxed);
    }
}

impl mlr_residual::Progress for Steps {
    fn expect_more(&self, steps: usize) {
        mlr_ga::Progress::expect_more(self, steps);
    }

    fn advance(&self) {
        mlr_ga::Progress::advance(self);
    }
}

/// With how many threads a call computes, and whom it tells how far it is.
#[derive(Debug, pyo3::FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Running {
    /// One per core where there is no number.
    threads: Option<i64>,
    /// Called with the steps done and expected.
    progress: Option<Py<PyAny>>,
}

impl Running {
    /// Computes on threads of its own and waits without holding the interpreter.
    ///
    /// A signal handler or a `progress` that raises ends the wait at once. The computation itself ends at its
    /// next step; it holds nothing of Python's.
    pub(crate) fn run<T: Send + 'static>(
        self,
        py: Python<'_>,
        compute: impl FnOnce(&Steps) -> anyhow::Result<T> + Send + 'static,
    ) -> PyResult<T> {
        let threads = threads(self.threads).map_err(|error| exception(&error.into()))?;
        let pool = ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
        let steps = Arc::new(Steps::default());
        let (sender, mut receiver) = mpsc::channel();
        let of_the_computation = Arc::clone(&steps);
        pool.spawn(move || {
            let result = catch_unwind(AssertUnwindSafe(|| compute(&of_the_computation)));
            // Nobody receives what was given up.
            let _ = sender.send(result);
        });
        let mut told = None;
        loop {
            let (received, same) = py.detach(move || (receiver.recv_timeout(POLL), receiver));
            receiver = same;
            match received {
                Ok(Ok(result)) => return result.map_err(|error| exception(&error)),
                Ok(Err(panic)) => resume_unwind(panic as Box<dyn Any + Send>),
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(PyRuntimeError::new_err("the computation has disappeared"));
                }
                Err(RecvTimeoutError::Timeout) => {
                    let heard = py.check_signals();
                    let heard = heard.and_then(|()| self.tell(py, &steps, &mut told));
                    if let Err(raised) = heard {
                        steps.is_given_up.store(true, Ordering::Relaxed);
                        return Err(raised);
                    }
                }
            }
        }
    }

    /// Tells how far a computation is, where that is asked for and has changed.
    fn tell(
        &self,
        py: Python<'_>,
        steps: &Steps,
        told: &mut Option<(usize, usize)>,
    ) -> PyResult<()> {
        let Some(progress) = &self.progress else {
            return Ok(());
        };
        let done = steps.done.load(Ordering::Relaxed);
        let now = (done, steps.expected.load(Ordering::Relaxed).max(done));
        if now.1 > 0 && *told != Some(now) {
            *told = Some(now);
            progress.bind(py).call1(now)?;
        }
        Ok(())
    }
}

/// A number of threads as rayon takes it: zero is one per core.
fn threads(asked: Option<i64>) -> Result<usize, SettingError> {
    let Some(asked) = asked else {
        return Ok(0);
    };
    let most = i64::try_from(most_threads()).unwrap_or(i64::MAX);
    SettingError::check("threads", asked, 1..=most, "threads on this machine")?;
    Ok(usize::try_from(asked).unwrap_or_default())
}
