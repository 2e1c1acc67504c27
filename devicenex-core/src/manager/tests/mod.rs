mod addressing;
mod adopting;
mod bus;
mod connecting;
pub(super) mod edges;
mod stubborn;
mod talking;
mod two_managers;
mod unwilling;
