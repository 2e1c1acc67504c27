mod message;
mod server;
mod session;
