pub(super) mod edges;
