//! The codes of the frames.

link_core::codes! {
    /// The message type: bits 6-0 of the first POWERLINK byte.
    pub struct MessageType(u8), "message type" in hex {
        SOC = 0x01, "SoC";
        PREQ = 0x03, "PReq";
        PRES = 0x04, "PRes";
        SOA = 0x05, "SoA";
        ASND = 0x06, "ASnd";
        /// Of a redundant managing node.
        AMNI = 0x07, "AMNI";
        /// EPSG DS 302-B.
        AINV = 0x0D, "AInv";
    }
}

link_core::codes! {
    /// What the managing node invites a node to send: RequestedServiceID of a SoA.
    #[derive(Default)]
    pub struct RequestedService(u8), "requested service" in hex {
        NO_SERVICE = 0x00, "NoService";
        IDENT_REQUEST = 0x01, "IdentRequest";
        STATUS_REQUEST = 0x02, "StatusRequest";
        NMT_REQUEST_INVITE = 0x03, "NMTRequestInvite";
        /// EPSG DS 302-C.
        SYNC_REQUEST = 0x06, "SyncRequest";
        UNSPECIFIED_INVITE = 0xFF, "UnspecifiedInvite";
    }
}

link_core::codes! {
    /// What an ASnd carries: its ServiceID.
    pub struct ServiceId(u8), "ASnd service" in hex {
        IDENT_RESPONSE = 0x01, "IdentResponse";
        STATUS_RESPONSE = 0x02, "StatusResponse";
        NMT_REQUEST = 0x03, "NMTRequest";
        NMT_COMMAND = 0x04, "NMTCommand";
        SDO = 0x05, "SDO";
        /// EPSG DS 302-C.
        SYNC_RESPONSE = 0x06, "SyncResponse";
    }
}

link_core::codes! {
    /// An NMT command.
    pub struct NmtCommandId(u8), "NMT command" in hex {
        /// Only in an NMTRequest.
        IDENT_REQUEST = 0x01, "IdentRequest";
        /// Only in an NMTRequest.
        STATUS_REQUEST = 0x02, "StatusRequest";
        START_NODE = 0x21, "NMTStartNode";
        STOP_NODE = 0x22, "NMTStopNode";
        ENTER_PRE_OPERATIONAL_2 = 0x23, "NMTEnterPreOperational2";
        ENABLE_READY_TO_OPERATE = 0x24, "NMTEnableReadyToOperate";
        RESET_NODE = 0x28, "NMTResetNode";
        RESET_COMMUNICATION = 0x29, "NMTResetCommunication";
        RESET_CONFIGURATION = 0x2A, "NMTResetConfiguration";
        SW_RESET = 0x2B, "NMTSwReset";
        GO_TO_STANDBY = 0x2C, "NMTGoToStandby";
        DNA = 0x2D, "NMTDNA";
        START_NODE_EX = 0x41, "NMTStartNodeEx";
        STOP_NODE_EX = 0x42, "NMTStopNodeEx";
        ENTER_PRE_OPERATIONAL_2_EX = 0x43, "NMTEnterPreOperational2Ex";
        ENABLE_READY_TO_OPERATE_EX = 0x44, "NMTEnableReadyToOperateEx";
        RESET_NODE_EX = 0x48, "NMTResetNodeEx";
        RESET_COMMUNICATION_EX = 0x49, "NMTResetCommunicationEx";
        RESET_CONFIGURATION_EX = 0x4A, "NMTResetConfigurationEx";
        SW_RESET_EX = 0x4B, "NMTSwResetEx";
        NET_HOST_NAME_SET = 0x62, "NMTNetHostNameSet";
        FLUSH_ARP_ENTRY = 0x63, "NMTFlushArpEntry";
        PUBLISH_CONFIGURED_NODES = 0x80, "NMTPublishConfiguredNodes";
        PUBLISH_ACTIVE_NODES = 0x90, "NMTPublishActiveNodes";
        PUBLISH_PRE_OPERATIONAL_1 = 0x91, "NMTPublishPreOperational1";
        PUBLISH_PRE_OPERATIONAL_2 = 0x92, "NMTPublishPreOperational2";
        PUBLISH_READY_TO_OPERATE = 0x93, "NMTPublishReadyToOperate";
        PUBLISH_OPERATIONAL = 0x94, "NMTPublishOperational";
        PUBLISH_STOPPED = 0x95, "NMTPublishStopped";
        PUBLISH_NODE_STATES = 0x96, "NMTPublishNodeStates";
        PUBLISH_EMERGENCY_NEW = 0xA0, "NMTPublishEmergencyNew";
        PUBLISH_TIME = 0xB0, "NMTPublishTime";
        /// The answer to an NMTRequest that is not supported, and the value of 0x1F9E when it is read.
        INVALID_SERVICE = 0xFF, "NMTInvalidService";
    }
}

impl NmtCommandId {
    /// Whether the command data are a node list, and only the nodes in it are meant.
    #[must_use]
    pub const fn is_extended(self) -> bool {
        matches!(self.0, 0x41..=0x44 | 0x48..=0x4B)
    }

    /// The plain command that an extended one stands for; a plain one is itself.
    ///
    /// ```
    /// # use powerlink_core::wire::NmtCommandId;
    /// assert_eq!(NmtCommandId::RESET_NODE_EX.plain(), NmtCommandId::RESET_NODE);
    /// ```
    #[must_use]
    pub const fn plain(self) -> Self {
        if self.is_extended() { Self(self.0 ^ EXTENDED) } else { self }
    }

    /// The extended command of a plain one that has one; any other is itself.
    #[must_use]
    pub const fn extended(self) -> Self {
        if matches!(self.0, 0x21..=0x24 | 0x28..=0x2B) { Self(self.0 ^ EXTENDED) } else { self }
    }

    /// Whether it is a plain reset.
    #[must_use]
    pub const fn is_reset(self) -> bool {
        matches!(
            self,
            Self::RESET_NODE | Self::RESET_COMMUNICATION | Self::RESET_CONFIGURATION | Self::SW_RESET
        )
    }
}

link_core::codes! {
    /// The NMT state of a node, as it stands in frames.
    ///
    /// The low four bits name the super-state: 9 initialisation, C, D and E communicating, D "POWERLINK mode".
    pub struct NmtStateCode(u8), "NMT state" in hex {
        OFF = 0x00, "NMT_GS_OFF";
        INITIALISING = 0x19, "NMT_GS_INITIALISING";
        RESET_APPLICATION = 0x29, "NMT_GS_RESET_APPLICATION";
        RESET_COMMUNICATION = 0x39, "NMT_GS_RESET_COMMUNICATION";
        RESET_CONFIGURATION = 0x79, "NMT_GS_RESET_CONFIGURATION";
        NOT_ACTIVE = 0x1C, "NMT_NOT_ACTIVE";
        PRE_OPERATIONAL_1 = 0x1D, "NMT_PRE_OPERATIONAL_1";
        PRE_OPERATIONAL_2 = 0x5D, "NMT_PRE_OPERATIONAL_2";
        READY_TO_OPERATE = 0x6D, "NMT_READY_TO_OPERATE";
        OPERATIONAL = 0xFD, "NMT_OPERATIONAL";
        STOPPED = 0x4D, "NMT_CS_STOPPED";
        BASIC_ETHERNET = 0x1E, "NMT_CS_BASIC_ETHERNET";
    }
}

link_core::codes! {
    /// What went wrong, in an error entry.
    #[derive(Default)]
    pub struct ErrorCode(u16), "error" in hex {
        NONE = 0x0000, "no error";
        BAD_PHYSICAL_MODE = 0x8161, "bad physical mode";
        COLLISION = 0x8162, "collision";
        COLLISION_THRESHOLD = 0x8163, "collision threshold";
        CRC_THRESHOLD = 0x8164, "CRC threshold";
        LOSS_OF_LINK = 0x8165, "loss of link";
        MAC_BUFFER = 0x8166, "MAC buffer";
        ADDRESS_CONFLICT = 0x8201, "address conflict";
        MULTIPLE_MN = 0x8202, "multiple managing nodes";
        PDO_SHORT = 0x8210, "PDO too short";
        PDO_MAP_VERSION = 0x8211, "PDO mapping version";
        ASND_MTU_DIFFERENT = 0x8212, "ASnd MTU different";
        ASND_MTU_LIMIT = 0x8213, "ASnd MTU limit";
        ASND_TX_LIMIT = 0x8214, "ASnd transmit limit";
        CYCLE_LENGTH = 0x8231, "cycle length";
        CYCLE_EXCEEDED = 0x8232, "cycle exceeded";
        CYCLE_EXCEEDED_THRESHOLD = 0x8233, "cycle exceeded threshold";
        IDLE_LIMIT = 0x8234, "idle limit";
        JITTER_THRESHOLD = 0x8235, "SoC jitter threshold";
        LATE_PRES_THRESHOLD = 0x8236, "late PRes threshold";
        PREQ_OF_UNEXPECTED_CN = 0x8237, "PReq for unexpected CN";
        PREQ_LIMIT = 0x8238, "PReq limit";
        PRES_OF_UNEXPECTED_CN = 0x8239, "PRes of unexpected CN";
        PRES_RX_LIMIT = 0x823A, "PRes receive limit";
        PRES_TX_LIMIT = 0x823B, "PRes transmit limit";
        INVALID_FORMAT = 0x8241, "invalid format";
        LOSS_OF_PREQ_THRESHOLD = 0x8242, "loss of PReq threshold";
        LOSS_OF_PRES_THRESHOLD = 0x8243, "loss of PRes threshold";
        LOSS_OF_SOA_THRESHOLD = 0x8244, "loss of SoA threshold";
        LOSS_OF_SOC_THRESHOLD = 0x8245, "loss of SoC threshold";
        BOOT_OTHER_MN = 0x8410, "boot: another managing node";
        BOOT_NO_MN_SUPPORT = 0x8411, "boot: no managing node support";
        BOOT_NO_IDENT_RESPONSE = 0x8420, "boot step 1: no IdentResponse";
        BOOT_DEVICE_TYPE = 0x8421, "boot step 1: device type";
        BOOT_VENDOR_ID = 0x8422, "boot step 1: vendor ID";
        BOOT_PRODUCT_CODE = 0x8423, "boot step 1: product code";
        BOOT_REVISION = 0x8424, "boot step 1: revision";
        BOOT_SERIAL = 0x8425, "boot step 1: serial number";
        BOOT_CONFIGURATION = 0x8428, "boot step 1: configuration";
        BOOT_SOFTWARE = 0x842B, "boot step 1: software";
        BOOT_STEP_2 = 0x8430, "boot step 2";
        BOOT_CHECK_COMMUNICATION = 0x8440, "boot: check communication";
        WRONG_STATE = 0x8480, "wrong NMT state";
        NO_IDENT_RESPONSE = 0xF001, "no IdentResponse";
        NO_STATUS_RESPONSE = 0xF002, "no StatusResponse";
    }
}

link_core::codes! {
    /// A command of the SDO command layer.
    #[derive(Default)]
    pub struct SdoCommandId(u8), "SDO command" in hex {
        NIL = 0x00, "nil";
        WRITE_BY_INDEX = 0x01, "WriteByIndex";
        READ_BY_INDEX = 0x02, "ReadByIndex";
        WRITE_ALL_BY_INDEX = 0x03, "WriteAllByIndex";
        READ_ALL_BY_INDEX = 0x04, "ReadAllByIndex";
        WRITE_BY_NAME = 0x05, "WriteByName";
        READ_BY_NAME = 0x06, "ReadByName";
        FILE_WRITE = 0x20, "FileWrite";
        FILE_READ = 0x21, "FileRead";
        WRITE_MULTIPLE = 0x31, "WriteMultipleParameterByIndex";
        READ_MULTIPLE = 0x32, "ReadMultipleParameterByIndex";
        MAXIMUM_SEGMENT_SIZE = 0x70, "MaximumSegmentSize";
        LINK_NAME_TO_INDEX = 0x71, "LinkNameToIndex";
    }
}

link_core::codes! {
    /// Why an SDO command failed.
    pub struct AbortCode(u32), "abort" in hex {
        TIME_OUT = 0x0504_0000, "time-out";
        UNKNOWN_COMMAND = 0x0504_0001, "unknown command";
        INVALID_BLOCK_SIZE = 0x0504_0002, "invalid block size";
        INVALID_SEQUENCE_NUMBER = 0x0504_0003, "invalid sequence number";
        OUT_OF_MEMORY = 0x0504_0005, "out of memory";
        UNSUPPORTED_ACCESS = 0x0601_0000, "unsupported access";
        WRITE_ONLY = 0x0601_0001, "read of a write-only object";
        READ_ONLY = 0x0601_0002, "write to a read-only object";
        NO_OBJECT = 0x0602_0000, "object does not exist";
        NOT_MAPPABLE = 0x0604_0041, "object cannot be mapped";
        PDO_LENGTH = 0x0604_0042, "mapped objects exceed the PDO";
        PARAMETER_INCOMPATIBLE = 0x0604_0043, "parameter incompatible";
        LENGTH = 0x0607_0010, "length does not match";
        TOO_LONG = 0x0607_0012, "length too high";
        TOO_SHORT = 0x0607_0013, "length too low";
        NO_SUB_INDEX = 0x0609_0011, "sub-index does not exist";
        VALUE = 0x0609_0030, "value out of range";
        VALUE_TOO_HIGH = 0x0609_0031, "value too high";
        VALUE_TOO_LOW = 0x0609_0032, "value too low";
        GENERAL = 0x0800_0000, "general error";
        NOT_STORED = 0x0800_0020, "data cannot be stored";
        STATE = 0x0800_0022, "not in this state";
    }
}

/// The bits in which an extended command differs from its plain one.
const EXTENDED: u8 = 0x60;
