mod expectations;
mod socketcand;
mod svg;
