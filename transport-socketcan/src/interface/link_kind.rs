//! What `ip -d link show` tells and nothing else does: the kind of a link, which is the driver of a virtual one.

use std::io;

use neli::consts::nl::NlmF;
use neli::consts::rtnl::{Ifla, IflaInfo, RtAddrFamily, Rtm};
use neli::consts::socket::NlFamily;
use neli::nl::{NlPayload, Nlmsghdr, NlmsghdrBuilder};
use neli::rtnl::{Ifinfomsg, IfinfomsgBuilder};
use neli::socket::synchronous::NlSocketHandle;
use neli::utils::Groups;

/// `vcan`, `vxcan`, `can` for every controller; `None` for a driver that has no kind.
pub(super) fn link_kind(index: u32) -> io::Result<Option<String>> {
    let index = i32::try_from(index).map_err(io::Error::other)?;
    let link = IfinfomsgBuilder::default().ifi_family(RtAddrFamily::Unspecified).ifi_index(index);
    let request = NlmsghdrBuilder::default()
        .nl_type(Rtm::Getlink)
        .nl_flags(NlmF::REQUEST)
        .nl_payload(NlPayload::Payload(link.build().map_err(io::Error::other)?))
        .build()
        .map_err(io::Error::other)?;
    let socket = NlSocketHandle::connect(NlFamily::Route, None, Groups::empty()).map_err(io::Error::other)?;
    socket.send(&request).map_err(io::Error::other)?;
    let (mut answers, _) = socket.recv::<Rtm, Ifinfomsg>().map_err(io::Error::other)?;
    match answers.next().transpose().map_err(io::Error::other)? {
        Some(answer) => kind_in(&answer),
        None => Ok(None),
    }
}

fn kind_in(answer: &Nlmsghdr<Rtm, Ifinfomsg>) -> io::Result<Option<String>> {
    if let NlPayload::Err(error) = answer.nl_payload() {
        return Err(io::Error::from_raw_os_error(error.error().saturating_neg()));
    }
    let Some(link) = answer.get_payload() else { return Ok(None) };
    let attributes = link.rtattrs().get_attr_handle();
    let Ok(info) = attributes.get_nested_attributes::<IflaInfo>(Ifla::Linkinfo) else { return Ok(None) };
    Ok(info.get_attr_payload_as_with_len(IflaInfo::Kind).ok())
}
