//! The one list of wire types.

/// Calls a macro with every wire type of [`wire`](crate::wire): what is tested, fuzzed and documented for one is tested,
/// fuzzed and documented for all.
///
/// The callback gets the bare names, separated by commas; types that borrow their data have their lifetime left out.
///
/// ```
/// use link_core::codec::Wire as _;
/// use powerlink_core::wire;
///
/// macro_rules! names {
///     ($($Type:ident),*) => { [$(<wire::$Type as link_core::codec::Wire>::NAME),*] };
/// }
/// assert!(powerlink_core::for_each_wire_type!(names).contains(&"IdentResponse"));
/// ```
#[macro_export]
macro_rules! for_each_wire_type {
    ($callback:ident) => {
        $callback! {
            Soc,
            Preq,
            Pres,
            Soa,
            IdentResponse,
            StatusResponse,
            ErrorEntry,
            NmtCommand,
            NmtRequest,
            Sdo,
            SdoSequence,
            SdoCommand
        }
    };
}
