//! Requests beside the work: of the application to any node, the attributes that are read of each device, and new
//! addresses for devices that have one.

use cip_core::client::{Failure, Progress, StartError, Waits};
use cip_core::code::{ClassId, InstanceId, ServiceCode};
use cip_core::codec::{Wire, Writer};
use cip_core::message::{Request, Response, Target};
use heapless::Vec;
use link_core::Frame;

use super::database::Attribute;
use super::event::{ManagerEvent, PlannedEvent, RequestFailure, Value};
use super::machine::Manager;
use super::slot::Task;
use super::state::{Cause, DeviceState};
use super::timer::Timer;
use crate::client::{Conversation, Route, connection_response};
use crate::id::OperationalAddress;

/// One request at a time.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct Talk {
    pub(super) conversation: Conversation<MESSAGE>,
    stage: Stage,
    /// The explicit connection of the predefined set was refused.
    dynamic: bool,
    purpose: Purpose,
    address: OperationalAddress,
    request: Stored,
    /// From the service byte on, as the application finds it.
    response: Vec<u8, MESSAGE>,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
enum Stage {
    Idle,
    /// Until the manager itself has nothing to say to that node.
    Waiting,
    /// The explicit connection is asked for.
    Opening,
    Asking,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
enum Purpose {
    Application,
    /// Which of the attributes that are read of the device.
    Read(u8),
    /// What the application asks for.
    Readdress(OperationalAddress),
    /// A device that is not planned for this address goes to its own.
    Return(OperationalAddress),
}

/// A request, as it was given.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
struct Stored {
    connected: bool,
    service: ServiceCode,
    class: ClassId,
    instance: InstanceId,
    data: Vec<u8, MESSAGE>,
    tries: u8,
}

/// Why a request was not begun.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RequestError {
    /// The manager has no address, or not yet.
    #[error("the manager is not on line: wait for its access event")]
    NotOnline,
    /// To itself, or to nobody.
    #[error("OA {0} is not that of another node")]
    NotANode(OperationalAddress),
    /// One at a time.
    #[error("another request is under way: wait for its response")]
    Busy,
    /// More than the manager can hold.
    #[error("the request is longer than {MESSAGE} bytes")]
    TooLong,
    /// It is addressed by a path.
    #[error("the request names its object by a path: name class and instance")]
    Path,
    /// A connectionless request has eight bits for each.
    #[error("class, instance and attribute of a connectionless request are at most 255: use a connection")]
    NotAddressable,
}

impl Talk {
    pub(super) fn new(own: OperationalAddress, waits: Waits) -> Self {
        Self {
            conversation: Conversation::new(Route::connectionless(own, own), waits),
            stage: Stage::Idle,
            dynamic: false,
            purpose: Purpose::Application,
            address: OperationalAddress::NONE,
            request: Stored {
                connected: false,
                service: ServiceCode::GET_ATTRIBUTE_SINGLE,
                class: ClassId::IDENTITY,
                instance: InstanceId(1),
                data: Vec::new(),
                tries: 1,
            },
            response: Vec::new(),
        }
    }

    /// Whether it speaks with that node, or wants to.
    pub(super) fn is_with(&self, address: OperationalAddress) -> bool {
        self.address == address && self.stage != Stage::Idle
    }
}

impl<const DEVICES: usize, const CONNECTIONS: usize> Manager<DEVICES, CONNECTIONS> {
    /// Reads an attribute of any node without a connection. [`ManagerEvent::Response`] tells that
    /// [`response`](Self::response) is there.
    ///
    /// # Errors
    /// If another request is under way, or the manager is not on line.
    pub fn get(&mut self, to: OperationalAddress, attribute: Attribute) -> Result<(), RequestError> {
        let Some([.., number]) = attribute.short() else { return Err(RequestError::NotAddressable) };
        let Attribute { class, instance, .. } = attribute;
        let request =
            Request::new(ServiceCode::GET_ATTRIBUTE_SINGLE, class, instance, core::slice::from_ref(&number));
        self.begin_talk(to, Purpose::Application, &request, false, self.config.connect_tries)
    }

    /// Sends a request to any node, over its explicit connection, which is opened for it. More than one try only for
    /// services that may be carried out twice.
    ///
    /// # Errors
    /// If another request is under way, or the manager is not on line.
    pub fn request(
        &mut self,
        to: OperationalAddress,
        request: &Request<'_>,
        tries: u8,
    ) -> Result<(), RequestError> {
        self.begin_talk(to, Purpose::Application, request, true, tries)
    }

    /// Gives a node on line another address, over its explicit connection. It says Hello with it at once.
    ///
    /// # Errors
    /// If another request is under way, or the manager is not on line.
    pub fn readdress(
        &mut self,
        from: OperationalAddress,
        to: OperationalAddress,
    ) -> Result<(), RequestError> {
        if to == self.own() {
            return Err(RequestError::NotANode(to));
        }
        self.begin_readdress(from, to, Purpose::Readdress(to))
    }

    /// Has a device go to the address that is planned for it, over its explicit connection.
    ///
    /// # Errors
    /// If another request is under way, or the manager is not on line.
    pub(super) fn begin_return(
        &mut self,
        from: OperationalAddress,
        to: OperationalAddress,
    ) -> Result<(), RequestError> {
        self.begin_readdress(from, to, Purpose::Return(to))
    }

    /// The device that is planned for an address has it: whoever was to leave it has left.
    pub(super) fn end_return(&mut self, from: OperationalAddress) {
        if self.talk.is_with(from) && matches!(self.talk.purpose, Purpose::Return(_)) {
            self.abandon_talk();
        }
    }

    fn begin_readdress(
        &mut self,
        from: OperationalAddress,
        to: OperationalAddress,
        purpose: Purpose,
    ) -> Result<(), RequestError> {
        let value = [LINK_ADDRESS, to.number()];
        let request = Request::new(ServiceCode::SET_ATTRIBUTE_SINGLE, LINK, InstanceId(1), &value);
        self.begin_talk(from, purpose, &request, true, 1)
    }

    /// The response to the last request, if it was answered and no other has begun since.
    #[must_use]
    pub fn response(&self) -> Option<Response<'_>> {
        Response::parse(&self.talk.response).ok()
    }

    fn begin_talk(
        &mut self,
        to: OperationalAddress,
        purpose: Purpose,
        request: &Request<'_>,
        connected: bool,
        tries: u8,
    ) -> Result<(), RequestError> {
        if !self.access().is_online() {
            return Err(RequestError::NotOnline);
        }
        if to.is_none() || to == self.own() {
            return Err(RequestError::NotANode(to));
        }
        if self.talk.stage != Stage::Idle {
            return Err(RequestError::Busy);
        }
        let Target::Object { class, instance } = request.target else { return Err(RequestError::Path) };
        let data = Vec::from_slice(request.data).map_err(|_| RequestError::TooLong)?;
        self.talk.request = Stored { connected, service: request.service, class, instance, data, tries };
        self.talk.address = to;
        self.talk.purpose = purpose;
        self.talk.response.clear();
        self.talk.stage = Stage::Waiting;
        self.advance_talk();
        Ok(())
    }

    /// Begins what waits; or the next attribute that is to be read.
    pub(super) fn advance_talk(&mut self) {
        if self.talk.stage == Stage::Idle && self.is_working() {
            self.next_read();
        }
        let talks = |address| {
            self.place(address)
                .and_then(|place| self.slots.get(place))
                .is_some_and(|slot| slot.task != Task::None)
        };
        if self.talk.stage != Stage::Waiting || talks(self.talk.address) {
            return;
        }
        let (own, waits, to) = (self.own(), self.config.waits, self.talk.address);
        if self.talk.request.connected {
            self.talk.stage = Stage::Opening;
            self.talk.dynamic = false;
            self.talk.conversation.reroute(Route::connection(own, to), waits);
            self.open();
        } else {
            self.talk.conversation.reroute(Route::connectionless(own, to), waits);
            self.ask();
        }
    }

    /// Asks for the explicit connection.
    fn open(&mut self) {
        let asked = self.explicit_request(self.talk.dynamic);
        let started = self.talk.conversation.start_message(&asked, self.config.connect_tries);
        debug_assert_eq!(started, Ok(()));
        self.keep_talk_time();
    }

    fn next_read(&mut self) {
        let due = self.slots.iter().find(|slot| {
            slot.state == DeviceState::Running && usize::from(slot.reads) < slot.plan.reads.len()
        });
        let Some(slot) = due else { return };
        let (to, number) = (slot.address(), slot.reads);
        let Some(read) = slot.plan.reads.get(usize::from(number)).copied() else { return };
        // The plan was checked.
        let Some([.., attribute]) = read.short() else { return };
        let data = [attribute];
        let request = Request::new(ServiceCode::GET_ATTRIBUTE_SINGLE, read.class, read.instance, &data);
        // It waits until the present transaction with the device is over.
        let _ = self.begin_talk(to, Purpose::Read(number), &request, false, self.config.connect_tries);
    }

    /// Sends the request over the route that there is now.
    fn ask(&mut self) {
        self.talk.stage = Stage::Asking;
        let Stored { service, class, instance, data, tries, .. } = &self.talk.request;
        let request = Request::new(*service, *class, *instance, data);
        match self.talk.conversation.start(&request, *tries) {
            Ok(()) => self.keep_talk_time(),
            Err(
                StartError::TooLong { .. }
                | StartError::Busy
                | StartError::Empty
                | StartError::NotAddressable(_),
            ) => {
                self.end_talk(Err(RequestFailure::Failed(Failure::RequestTooLong)));
            }
        }
    }

    /// Whether it is an answer to the request.
    pub(super) fn answer_of_talk(&mut self, frame: &Frame) -> bool {
        let (own, to) = (self.own(), self.talk.address);
        let asked = self.explicit_request(self.talk.dynamic);
        let talk = &mut self.talk;
        let result = match talk.conversation.frame(frame) {
            Progress::NotMine | Progress::Ignored(_) => return false,
            Progress::Pending => {
                self.keep_talk_time();
                return true;
            }
            Progress::Response(response) if talk.stage == Stage::Opening => match response {
                // Another client has it: there are dynamic ones.
                Response::Error { .. } if !talk.dynamic => {
                    talk.dynamic = true;
                    self.open();
                    return true;
                }
                Response::Error { status, .. } => Err(RequestFailure::Refused(status)),
                Response::Success { .. } => {
                    let granted = connection_response(&asked, &response);
                    match granted.and_then(|granted| Route::opened(own, to, &asked, &granted)) {
                        Some(route) => {
                            talk.conversation.reroute(route, self.config.waits);
                            self.ask();
                            return true;
                        }
                        None => Err(RequestFailure::Failed(Failure::Malformed)),
                    }
                }
            },
            Progress::Response(response) => {
                let mut buffer = [0; MESSAGE];
                let mut out = Writer::new(&mut buffer);
                let fits = response.emit(&mut out);
                debug_assert!(fits.is_ok());
                talk.response = Vec::from_slice(out.written()).unwrap_or_default();
                match response {
                    Response::Success { .. } => Ok(()),
                    Response::Error { status, .. } => Err(RequestFailure::Refused(status)),
                }
            }
            Progress::Failed(failure) => Err(RequestFailure::Failed(failure)),
        };
        self.end_talk(result);
        true
    }

    /// No answer came in time.
    pub(super) fn talk_over(&mut self) {
        let failure = self.talk.conversation.timer_expired();
        self.keep_talk_time();
        if let Some(failure) = failure {
            self.end_talk(Err(RequestFailure::Failed(failure)));
        }
    }

    fn end_talk(&mut self, result: Result<(), RequestFailure>) {
        self.keep_talk_time();
        self.talk.stage = Stage::Idle;
        let from = self.talk.address;
        match self.talk.purpose {
            Purpose::Application => self.raise(match result {
                Err(why) if self.talk.response.is_empty() => ManagerEvent::RequestFailed(from, why),
                // A refusal is a response.
                Ok(()) | Err(_) => ManagerEvent::Response(from),
            }),
            Purpose::Readdress(to) | Purpose::Return(to) => self.readdressed(from, to, result),
            Purpose::Read(number) => self.end_read(from, number, result),
        }
        if let Some(place) = self.place(from) {
            self.advance_slot(place);
        }
    }

    fn readdressed(
        &mut self,
        from: OperationalAddress,
        to: OperationalAddress,
        result: Result<(), RequestFailure>,
    ) {
        self.raise(ManagerEvent::Readdressed { from, to, result });
        let Some(place) = self.place(from) else { return };
        if result.is_ok() && self.slots.get(place).is_some_and(|slot| slot.state == DeviceState::Conflict) {
            // Who had it is gone.
            self.begin_probe(place, Cause::WaitOver);
        }
    }

    fn end_read(&mut self, from: OperationalAddress, number: u8, result: Result<(), RequestFailure>) {
        let Some(place) = self.place(from) else { return };
        let value = result.and_then(|()| match self.response() {
            Some(Response::Success { data, .. }) => {
                Value::from_slice(data).map_err(|_| RequestFailure::Failed(Failure::ResponseTooLong))
            }
            Some(Response::Error { .. }) | None => Err(RequestFailure::Failed(Failure::Malformed)),
        });
        let Some(slot) = self.slot(place) else { return };
        slot.reads = number.saturating_add(1);
        if let Some(attribute) = slot.plan.reads.get(usize::from(number)).copied() {
            self.tell(place, PlannedEvent::Read(attribute, value));
        }
    }

    /// Nobody waits for the answer any more, or nobody is there who would give it.
    pub(super) fn abandon_talk(&mut self) {
        if self.talk.stage != Stage::Idle {
            self.talk.conversation.cancel();
            self.end_talk(Err(RequestFailure::Failed(Failure::NoResponse)));
        }
    }

    pub(super) fn keep_talk_time(&mut self) {
        self.talk.conversation.take_timer().apply(&mut self.timers, Timer::Talk);
    }
}

/// The longest request and response of the application.
const MESSAGE: usize = 128;
/// The link object, and its attribute that is the address.
const LINK: ClassId = ClassId(0x03);
const LINK_ADDRESS: u8 = 1;
