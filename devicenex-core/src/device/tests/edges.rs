//! Both state machines, over the wire: every row of their tables is reached.

use std::cell::RefCell;
use std::vec::Vec;

use cip_core::connection::{ExplicitCause, ExplicitEdge, ExplicitState, IoCause, IoEdge, IoState};

std::thread_local! {
    static IO: RefCell<Vec<IoEdge>> = const { RefCell::new(Vec::new()) };
    static EXPLICIT: RefCell<Vec<ExplicitEdge>> = const { RefCell::new(Vec::new()) };
}

pub(in crate::device) fn record_io(from: IoState, cause: IoCause, to: IoState) {
    IO.with_borrow_mut(|edges| edges.push(IoEdge { from, cause, to }));
}

pub(in crate::device) fn record_message(state: IoState) {
    record_io(state, IoCause::Message, state);
}

pub(in crate::device) fn record_explicit(from: ExplicitState, cause: ExplicitCause, to: ExplicitState) {
    EXPLICIT.with_borrow_mut(|edges| edges.push(ExplicitEdge { from, cause, to }));
}
