//! The one list of wire types.

/// Calls a macro with every wire type of [`message`](crate::message): what is tested, fuzzed and documented for one is
/// tested, fuzzed and documented for all.
///
/// The callback gets the bare names, separated by commas; types that borrow their data have their lifetime left out.
///
/// ```
/// use devicenex_core::message::{self, Wire as _};
///
/// macro_rules! names {
///     ($($Type:ident),*) => { [$(<message::$Type as message::Wire>::NAME),*] };
/// }
/// assert!(devicenex_core::for_each_wire_type!(names).contains(&"ROAM"));
/// ```
#[macro_export]
macro_rules! for_each_wire_type {
    ($callback:ident) => {
        $callback! {
            HelloData,
            RoamData,
            ConnectionRequest,
            ConnectionResponse,
            ErrorResponse,
            ConnectionlessRequest,
            ConnectionlessResponse,
            ExplicitMessage,
            FirstFragment,
            NextFragment,
            FragmentAcknowledge,
            ImplicitFragment
        }
    };
}
