mod addressing;
mod bus;
mod connecting;
pub(super) mod edges;
mod talking;
mod two_managers;
