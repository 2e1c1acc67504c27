//! A request, resolved to the object it is for.

use super::Failure;
use crate::code::{AttributeId, ClassId, GeneralStatus, InstanceId, ServiceCode};
use crate::epath::{Epath, LogicalKind, Segment};
use crate::message::{Request, Target};

/// A request whose object is known by its IDs, however the body format spelled them.
///
/// A server whose connections all use the format 8/8 makes it with [`new`](Self::new) from the first three bytes, and
/// carries no code for paths.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Call<'a> {
    /// The service.
    pub service: ServiceCode,
    /// The class.
    pub class: ClassId,
    /// The instance; 0 is the class itself.
    pub instance: InstanceId,
    /// The attribute, if it is in the path; else it is in front of the data of the services that need one.
    pub path_attribute: Option<AttributeId>,
    /// The service data.
    pub data: &'a [u8],
    route: Route,
}

/// How a request names its object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum Route {
    /// Formats 0-3.
    Ids,
    /// Format 4.
    Path,
    /// Format 4, with something behind the IDs that is no segment.
    MalformedPath,
}

impl<'a> Call<'a> {
    /// A request in one of the formats 0-3.
    pub const fn new(service: ServiceCode, class: ClassId, instance: InstanceId, data: &'a [u8]) -> Self {
        Self { service, class, instance, path_attribute: None, data, route: Route::Ids }
    }

    /// The call that a request is; 0x04 (path segment error) if its path names no class.
    ///
    /// A path that goes wrong after its class is judged in the order of the checks: 0x16 first if what it names does
    /// not exist.
    pub fn of(request: &Request<'a>) -> Result<Self, Failure> {
        match request.target {
            Target::Object { class, instance } => {
                Ok(Self::new(request.service, class, instance, request.data))
            }
            Target::Path(path) => Self::by_path(request, path),
        }
    }

    /// True if the object was named by a path (format 4).
    pub const fn is_by_path(&self) -> bool {
        matches!(self.route, Route::Path | Route::MalformedPath)
    }

    /// The attribute of a service for one attribute, and the data behind it; 0x13 if it is missing.
    pub fn attribute(&self) -> Result<(AttributeId, &'a [u8]), Failure> {
        if let Some(attribute) = self.path_attribute {
            return Ok((attribute, self.data));
        }
        let (&attribute, value) =
            self.data.split_first().ok_or(Failure::new(GeneralStatus::NOT_ENOUGH_DATA))?;
        Ok((AttributeId(attribute.into()), value))
    }

    /// Demands a service without data: 0x15 if there are any.
    pub fn no_data(&self) -> Result<(), Failure> {
        if self.data.is_empty() { Ok(()) } else { Err(GeneralStatus::TOO_MUCH_DATA.into()) }
    }

    /// Row 5 of the order of checks.
    pub(super) fn check_path(&self) -> Result<(), Failure> {
        match self.route {
            Route::Ids | Route::Path => Ok(()),
            Route::MalformedPath => Err(GeneralStatus::PATH_SEGMENT_ERROR.into()),
        }
    }

    fn by_path(request: &Request<'a>, path: Epath<'_>) -> Result<Self, Failure> {
        let mut class = None;
        let mut call = Self::new(request.service, ClassId(0), InstanceId::CLASS, request.data);
        call.route = Route::Path;
        for segment in path.segments() {
            let (kind, id) = match segment {
                Ok(Segment::Logical { kind, value, .. }) => (kind, u16::try_from(value)),
                Ok(_) => continue,
                Err(_) => {
                    call.route = Route::MalformedPath;
                    break;
                }
            };
            match (kind, id) {
                (LogicalKind::Class, Ok(id)) => class = Some(ClassId(id)),
                (LogicalKind::Instance, Ok(id)) => call.instance = InstanceId(id),
                (LogicalKind::Attribute, Ok(id)) => call.path_attribute = Some(AttributeId(id)),
                (LogicalKind::Class | LogicalKind::Instance | LogicalKind::Attribute, Err(_)) => {
                    call.route = Route::MalformedPath;
                    break;
                }
                (LogicalKind::Member | LogicalKind::ConnectionPoint | LogicalKind::Service, _) => {}
            }
        }
        call.class = class.ok_or(Failure::new(GeneralStatus::PATH_SEGMENT_ERROR))?;
        Ok(call)
    }
}
