//! The signals of a participant: bound by name, read and written by handle.

use std::ffi::c_int;

use formation::wiring::{Interface, Refusal, Role};
use lockstep::{Io, Slice, Timing};

use crate::participant::{Participant, Stage, role_of};

/// A bound signal; its place in the list is its handle.
#[derive(Clone, Copy)]
pub(super) enum Port {
    Input(Slice),
    Output(Slice),
}

impl Participant {
    /// Binds an input; returns its handle.
    pub(crate) fn input(&mut self, channel: &str, agent: c_int, signal: &str, length: c_int) -> Result<c_int, String> {
        let role = role_of(channel, Role::channel, "channel")?;
        let (agent, length) = (self.agent(agent)?, positive(signal, length)?);
        let slice = self.binding()?.input(role, agent, signal, length);
        Ok(self.keep(Port::Input(slice.map_err(|Refusal(reason)| reason)?)))
    }

    /// Binds an input of any role, of this step or of the step before; returns its handle. Length 0 is that of the signal.
    pub(crate) fn signal(
        &mut self,
        role: &str,
        agent: c_int,
        signal: &str,
        length: c_int,
        before: bool,
    ) -> Result<c_int, String> {
        let role = role_of(role, Role::name, "role")?;
        let agent = self.agent(agent)?;
        let interface = self.binding()?;
        let length = match length {
            0 => interface.size(role, agent, signal).map_err(|Refusal(reason)| reason)?,
            _ => positive(signal, length)?,
        };
        let timing = if before { Timing::Delayed } else { Timing::SameStep };
        let slice = interface.signal(role, agent, signal, length, timing);
        Ok(self.keep(Port::Input(slice.map_err(|Refusal(reason)| reason)?)))
    }

    /// How many numbers a signal has.
    pub(crate) fn size(&self, role: &str, agent: c_int, signal: &str) -> Result<c_int, String> {
        let role = role_of(role, Role::name, "role")?;
        let agent = self.agent(agent)?;
        let size = self.interface()?.size(role, agent, signal).map_err(|Refusal(reason)| reason)?;
        Ok(size as c_int)
    }

    /// Binds an output; returns its handle.
    pub(crate) fn output(&mut self, agent: c_int, signal: &str, length: c_int) -> Result<c_int, String> {
        let (agent, length) = (self.agent(agent)?, positive(signal, length)?);
        let slice = self.binding()?.output(agent, signal, length);
        Ok(self.keep(Port::Output(slice.map_err(|Refusal(reason)| reason)?)))
    }

    /// Where the numbers of an input are.
    pub(crate) fn read(&mut self, handle: c_int) -> Result<*const f64, String> {
        match (self.port(handle)?, self.io()) {
            (Port::Input(slice), Some(io)) => Ok(io.input_pointer(slice)),
            (Port::Output(_), _) => Err(format!("read: {handle} is an output, not an input")),
            (_, None) => Err("read: no step is in progress".into()),
        }
    }

    /// Where the numbers of an output belong.
    pub(crate) fn write(&mut self, handle: c_int) -> Result<*mut f64, String> {
        match (self.port(handle)?, self.io()) {
            (Port::Output(slice), Some(mut io)) => Ok(io.output_pointer(slice)),
            (Port::Input(_), _) => Err(format!("write: {handle} is an input, not an output")),
            (_, None) => Err("write: no step is in progress".into()),
        }
    }

    /// Writes zeros where nothing is bound. Numbers of bound outputs that the program forgets are found by the check of the
    /// outputs.
    pub(super) fn write_unbound(&mut self) {
        let Some((link, unbound)) = self.running() else { return };
        let Some(mut io) = link.io() else { return };
        unbound.iter().for_each(|slice| io.slice_mut(*slice).fill(0.0));
    }

    fn io(&mut self) -> Option<Io<'_>> {
        match &mut self.stage {
            Stage::Running(link) => link.io(),
            _ => None,
        }
    }

    fn port(&self, handle: c_int) -> Result<Port, String> {
        let port = usize::try_from(handle).ok().and_then(|place| self.ports.get(place));
        match port {
            Some((owner, _)) if *owner != self.due => Err(format!(
                "{handle} is a signal of another participant of this process than the one whose step this is"
            )),
            Some((_, port)) => Ok(*port),
            None => {
                Err(format!("{handle} is no handle of a signal; binding an input or an output returns such handles"))
            }
        }
    }

    fn keep(&mut self, port: Port) -> c_int {
        self.ports.push((self.selected(), port));
        self.ports.len() as c_int - 1
    }

    /// The interface to bind signals of, as long as that is possible.
    fn binding(&self) -> Result<&Interface, String> {
        match (&self.stage, self.seat()) {
            (Stage::Binding(_), Some(interface)) => Ok(interface),
            (Stage::Running(_), _) => Err("signals can be bound before the first step only".into()),
            _ => Err("signals can be bound in a run only".into()),
        }
    }
}

fn positive(signal: &str, length: c_int) -> Result<usize, String> {
    let length = usize::try_from(length).ok().filter(|&length| length > 0);
    length.ok_or_else(|| format!("the signal `{signal}` was asked for with a length that is not positive"))
}
