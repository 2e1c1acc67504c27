//! Node IDs.

link_core::codes! {
    /// The POWERLINK address of a node.
    ///
    /// | ID | Meaning |
    /// |---|---|
    /// | 0 | nobody |
    /// | 1-239 | controlled nodes |
    /// | 240 | managing node |
    /// | 241-250 | reserved, redundancy |
    /// | 251 | the node itself |
    /// | 252 | dummy |
    /// | 253 | diagnostic device |
    /// | 254 | router to other Ethernet |
    /// | 255 | all |
    ///
    /// ```
    /// use powerlink_core::NodeId;
    ///
    /// assert_eq!((NodeId(7).to_string(), NodeId::MANAGING_NODE.to_string()), ("node 7".into(), "MN".into()));
    /// assert!(NodeId(7).is_controlled_node() && !NodeId::MANAGING_NODE.is_controlled_node());
    /// ```
    #[derive(Default)]
    pub struct NodeId(u8), "node" in decimal {
        NONE = 0, "nobody";
        MANAGING_NODE = 240, "MN";
        SELF = 251, "self";
        DUMMY = 252, "dummy";
        DIAGNOSTIC = 253, "diagnostic device";
        ROUTER = 254, "router";
        BROADCAST = 255, "all";
    }
}

impl NodeId {
    /// Whether a controlled node may have it: 1 to 239, the diagnostic device and the router.
    #[must_use]
    pub const fn is_controlled_node(self) -> bool {
        matches!(self.0, 1..=239 | 253 | 254)
    }
}
