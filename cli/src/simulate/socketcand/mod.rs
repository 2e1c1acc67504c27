mod message;
mod session;
