//! CIP (Common Industrial Protocol) without a network: what every object, client, server and decoder of a CIP network
//! on CAN needs, and no identifier of any.
//!
//! | Module | Content |
//! |---|---|
//! | [`codec`] | bounded reading and writing of bytes, the [`Wire`](codec::Wire) trait |
//! | [`client`] | one request to a server, and its response: transactions, fragments, repetitions |
//! | [`code`] | service codes, general statuses, class, instance and attribute IDs, vendors, device types, data types |
//! | [`data_type`] | elementary data types and their values |
//! | [`epath`] | paths to objects, attributes and devices |
//! | [`message`] | explicit request and response bodies in the five body formats, and the bodies of the services |
//! | [`fragment`] | cutting and reassembly of messages longer than a CAN frame |
//! | [`identity`] | who a device is, its status and state |
//! | [`connection`] | the Connection object: attributes, state machines, time-outs, production |
//! | [`parameter`] | the descriptors of the Parameter object |
//! | [`scan`] | what a master must know of a slave: an entry of its scan list |
//! | [`names`] | attributes and services of the object classes, with their types |
//! | [`monitor`] | what the passive decoders of the networks share |
//! | [`object`] | the objects of a device, and the checks that a request meets |
//! | [`transfer`] | one explicit connection as a pipe: a request in, its response out |
//! | [`value`] | attribute values in words |
//! | [`text`] | formatting without allocation |
//! | `eds` | Electronic Data Sheets: parser, checker, values of parameters in words (feature `std`) |
//!
//! Everything but `eds` is `no_std` without `alloc`. Bytes from the bus can be wrong in any way: they yield a typed error
//! that names the field, never a panic. Codes are open: a value without a name survives a round trip and prints as a number.
//!
//! # A request, decoded
//!
//! ```
//! use cip_core::code::{AttributeId, ClassId, InstanceId, ServiceCode};
//! use cip_core::message::{BodyFormat, Request};
//!
//! // Get_Attribute_Single, Identity object, instance 1, attribute 7 (product name), in the 8/8 format.
//! let body = [0x0E, 0x01, 0x01, 0x07];
//! let request = Request::parse(BodyFormat::Class8Instance8, &body)?;
//! assert_eq!(request.service, ServiceCode::GET_ATTRIBUTE_SINGLE);
//! assert_eq!(request.target.class(), Some(ClassId::IDENTITY));
//! assert_eq!(request.target.instance(), Some(InstanceId(1)));
//! let access = request.attribute_access()?;
//! assert_eq!(access.attribute, AttributeId(7));
//! assert_eq!(request.to_string(), "Get_Attribute_Single Identity instance 1, Product name");
//! # Ok::<(), cip_core::codec::ParseError>(())
//! ```
//!
//! # Features
//!
//! All are additive. `serde` derives serialisation, `defmt` the formatting of embedded loggers, `std` has `eds` and passes
//! itself on to the dependencies.

#![no_std]
#![forbid(unsafe_code)]

#[cfg(any(test, feature = "std"))]
extern crate std;

pub mod client;
pub mod code;
pub mod connection;
pub mod data_type;
#[cfg(feature = "std")]
pub mod eds;
pub mod epath;
pub mod fragment;
pub mod identity;
pub mod message;
pub mod monitor;
pub mod names;
pub mod object;
pub mod parameter;
pub mod scan;
pub mod transfer;
pub mod value;
mod wire_types;

pub use link_core::{codec, text};
