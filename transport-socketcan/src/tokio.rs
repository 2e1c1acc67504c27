//! The same port for tokio.

use core::ops::ControlFlow;
use std::io;
use std::os::fd::{AsFd, OwnedFd};

use link_core::drive::drain;
use link_core::machine::Deadline;
use link_core::{Input, Instant, Machine, Port};
use tokio::io::Interest;
use tokio::io::unix::AsyncFd;

use crate::SocketCanPort;
use crate::error::Error;

/// A [`SocketCanPort`] whose waiting is a future, so that one thread runs many machines.
///
/// Tokio's timers have a resolution of a millisecond; a machine hears of its deadline at most that late. Frames bear the
/// kernel's time all the same.
#[derive(Debug)]
pub struct TokioPort {
    port: SocketCanPort,
    /// The same socket, as the reactor knows it, and which of the port's it is.
    ready: AsyncFd<OwnedFd>,
    generation: u32,
}

impl TokioPort {
    /// Makes a port asynchronous. To be called inside of a runtime with `enable_io` and `enable_time`.
    ///
    /// # Errors
    /// When the runtime does not take the socket.
    pub fn new(port: SocketCanPort) -> Result<Self, Error> {
        let generation = port.link.generation();
        let ready = register(&port)?;
        Ok(Self { port, ready, generation })
    }

    /// The port, for everything that does not wait.
    pub const fn port(&mut self) -> &mut SocketCanPort {
        &mut self.port
    }

    /// Waits for the next input, at most until the deadline, as [`Port::wait`] does.
    ///
    /// Cancel safe: an input that was not returned is returned by the next call.
    ///
    /// # Errors
    /// When the transport has failed for good.
    pub async fn wait(&mut self, deadline: Option<Deadline>) -> Result<(Instant, Input), Error> {
        let deadline = deadline.map(|deadline| deadline.at);
        loop {
            if let Some(input) = self.port.link.next()? {
                return Ok(input);
            }
            let now = self.port.link.now();
            if deadline.is_some_and(|at| at <= now) {
                // What came before this moment comes first.
                self.port.link.readable();
                return Ok(self.port.link.next()?.unwrap_or((now, Input::Tick)));
            }
            let until = [deadline, self.port.link.wake_at()].into_iter().flatten().min();
            self.sleep(now, until).await?;
            self.port.link.readable();
            if let Some(input) = self.port.link.next()? {
                return Ok(input);
            }
            self.port.link.wake()?;
        }
    }

    async fn sleep(&mut self, now: Instant, until: Option<Instant>) -> Result<(), Error> {
        if self.generation != self.port.link.generation() {
            self.ready = register(&self.port)?;
            self.generation = self.port.link.generation();
        }
        // A moment that the clock cannot express is later than anybody waits.
        let until =
            until.and_then(|until| tokio::time::Instant::now().checked_add(until.saturating_since(now)));
        if !self.port.link.is_open() {
            // The socket of an interface that is gone is always ready, with an error.
            match until {
                Some(until) => tokio::time::sleep_until(until).await,
                None => core::future::pending().await,
            }
            return Ok(());
        }
        let readable = self.ready.readable();
        let ready = match until {
            Some(until) => tokio::time::timeout_at(until, readable).await.ok(),
            None => Some(readable.await),
        };
        // Before the socket is drained: what comes after that makes it ready again.
        match ready {
            Some(Ok(mut guard)) => guard.clear_ready(),
            Some(Err(source)) => return Err(failed(&self.port, source)),
            None => {}
        }
        Ok(())
    }
}

/// Runs a machine on a port until `on_event` breaks or the port fails, as [`link_core::drive()`] does.
///
/// # Errors
/// The first error of the port.
pub async fn drive<M: Machine, B>(
    machine: &mut M,
    port: &mut TokioPort,
    mut on_event: impl FnMut(&mut M, Instant, M::Event) -> ControlFlow<B>,
) -> Result<B, Error> {
    let mut now = port.port.now();
    loop {
        if let ControlFlow::Break(value) = drain(machine, &mut port.port, now, &mut on_event)? {
            return Ok(value);
        }
        let input;
        (now, input) = port.wait(machine.deadline()).await?;
        machine.input(now, input);
    }
}

#[allow(
    deprecated,
    reason = "its successor is unsafe, for a type may give its descriptor away; an `OwnedFd` that nobody else has does not"
)]
fn register(port: &SocketCanPort) -> Result<AsyncFd<OwnedFd>, Error> {
    let socket = port.link.as_fd().try_clone_to_owned().map_err(|source| failed(port, source))?;
    AsyncFd::with_interest(socket, Interest::READABLE).map_err(|source| failed(port, source))
}

fn failed(port: &SocketCanPort, source: io::Error) -> Error {
    Error::Socket { name: port.interface().name().into(), what: "cannot wait for frames", source }
}
