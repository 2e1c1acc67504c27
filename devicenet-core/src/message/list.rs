//! The one list of wire types.

/// Calls a macro with every wire type of [`message`](crate::message): what is tested, fuzzed and documented for one is
/// tested, fuzzed and documented for all.
///
/// The callback gets the bare names, separated by commas; types that borrow their data have their lifetime left out.
///
/// ```
/// use devicenet_core::message::{self, Wire as _};
///
/// macro_rules! names {
///     ($($Type:ident),*) => { [$(<message::$Type as message::Wire>::NAME),*] };
/// }
/// assert!(devicenet_core::for_each_wire_type!(names).contains(&"heartbeat"));
/// ```
#[macro_export]
macro_rules! for_each_wire_type {
    ($callback:ident) => {
        $callback! {
            DuplicateMacCheck,
            ExplicitHeader,
            ExplicitMessage,
            ExplicitFragment,
            FragmentAcknowledge,
            ErrorResponse,
            UnconnectedAllocate,
            UnconnectedAllocateResponse,
            UnconnectedRelease,
            UnconnectedReleaseResponse,
            OpenRequest,
            OpenResponse,
            CloseRequest,
            CloseResponse,
            Heartbeat,
            Shutdown,
            OfflineOwnership,
            WhoRequest,
            WhoResponse,
            IdentifyRequest,
            IdentifyDeviceRequest,
            IdentifyResponse,
            ChangeMacIdRequest,
            CommunicationFaultedRequest,
            CommunicationFaultedResponse,
            BitStrobeCommand,
            EmptyIo,
            IoFragment
        }
    };
}
