//! Explicit messages from the service byte on: requests, responses, and the bodies of the services.
//!
//! What stands before the service byte (the header with MAC ID, transaction ID and fragment flag) belongs to the
//! network.
//!
//! | | Service byte | then |
//! |---|---|---|
//! | Request | service code | class and instance, or a path, in the [`BodyFormat`] of the connection; service data |
//! | Response | service code + 0x80 | service data |
//! | Error response | 0x94 | general status, additional code (0xFF: none) |

mod allocate;
mod describe;
mod format;
mod list;
mod member;
mod packet;
mod request;
mod response;
mod service;

pub use allocate::{AllocateRequest, AllocateResponse, AllocationChoice, ReleaseRequest};
pub use describe::{Answer, Subject};
pub use format::BodyFormat;
pub use list::{
    AttributeReplies, AttributeReply, AttributeSettings, AttributeStatusList, InstanceList, ListError,
    UintList,
};
pub use member::{MemberId, MemberRequest};
pub use packet::{MultipleServicePacket, emit_packets};
pub use request::{AttributeAccess, AttributeRequest, EmitError, Request, Target};
pub use response::Response;
pub use service::{CreateResponse, FindNextRequest, ResetRequest, ResetType};

#[cfg(test)]
mod tests;
