//! The one list of wire types.

/// Calls a macro with every type of this crate that implements [`Wire`](crate::codec::Wire), as paths separated by
/// commas: what is tested, fuzzed and documented for one is so for all. Lifetimes are left out.
///
/// ```
/// use cip_core::codec::Wire;
///
/// macro_rules! names {
///     ($($Type:ty),*) => { [$(<$Type as Wire>::NAME),*] };
/// }
/// assert!(cip_core::for_each_wire_type!(names).contains(&"Allocate request"));
/// ```
#[macro_export]
macro_rules! for_each_wire_type {
    ($callback:ident) => {
        $callback! {
            $crate::identity::IdentityAttributes,
            $crate::identity::ProductName,
            $crate::identity::Revision,
            $crate::message::AllocateRequest,
            $crate::message::AllocateResponse,
            $crate::message::AttributeReplies,
            $crate::message::AttributeSettings,
            $crate::message::AttributeStatusList,
            $crate::message::CreateResponse,
            $crate::message::FindNextRequest,
            $crate::message::InstanceList,
            $crate::message::MemberId,
            $crate::message::MemberRequest,
            $crate::message::MultipleServicePacket,
            $crate::message::ReleaseRequest,
            $crate::message::ResetRequest,
            $crate::message::Response,
            $crate::message::UintList
        }
    };
}

#[cfg(test)]
mod tests {
    use crate::codec::laws;
    use proptest::{collection::vec, prelude::*};

    macro_rules! check_all {
        ($($Type:ty),*) => {
            /// True if any type accepts the bytes; all that do keep the laws.
            fn accepted_by_any(bytes: &[u8]) -> bool {
                [$(laws::accepted_bytes_survive::<$Type>(bytes, &mut [0; 64])),*].contains(&true)
            }
        };
    }

    crate::for_each_wire_type!(check_all);

    /// Short messages, and such whose first bytes are a plausible count.
    fn near_messages() -> impl Strategy<Value = std::vec::Vec<u8>> {
        let counted = (0..6_u8, 0..2_u8, vec(any::<u8>(), 0..24))
            .prop_map(|(low, high, rest)| [&[low, high][..], &rest].concat());
        prop_oneof![vec(any::<u8>(), 0..50), counted]
    }

    proptest! {
        #[test]
        fn accepted_bytes_are_emitted_again(bytes in near_messages()) {
            let accepted = accepted_by_any(&bytes);
            prop_assert!(accepted || !bytes.is_empty(), "nothing at all is a Reset request");
        }
    }
}
