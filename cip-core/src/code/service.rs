//! Service codes (CIP Vol. 1, appendix A).

super::codes! {
    /// A service code: the low seven bits of the service byte.
    ///
    /// Only the common services have a name here. What the codes of an object class mean says
    /// the class of the request.
    ///
    /// ```
    /// # use cip_core::code::ServiceCode;
    /// assert_eq!(ServiceCode::split(0x8E), (ServiceCode::GET_ATTRIBUTE_SINGLE, true));
    /// assert_eq!(ServiceCode::GET_ATTRIBUTE_SINGLE.response_byte(), 0x8E);
    /// ```
    pub struct ServiceCode(u8), "service" in hex {
        GET_ATTRIBUTES_ALL = 0x01, "Get_Attributes_All";
        SET_ATTRIBUTES_ALL = 0x02, "Set_Attributes_All";
        GET_ATTRIBUTE_LIST = 0x03, "Get_Attribute_List";
        SET_ATTRIBUTE_LIST = 0x04, "Set_Attribute_List";
        RESET = 0x05, "Reset";
        START = 0x06, "Start";
        STOP = 0x07, "Stop";
        CREATE = 0x08, "Create";
        DELETE = 0x09, "Delete";
        MULTIPLE_SERVICE_PACKET = 0x0A, "Multiple_Service_Packet";
        APPLY_ATTRIBUTES = 0x0D, "Apply_Attributes";
        GET_ATTRIBUTE_SINGLE = 0x0E, "Get_Attribute_Single";
        SET_ATTRIBUTE_SINGLE = 0x10, "Set_Attribute_Single";
        FIND_NEXT_OBJECT_INSTANCE = 0x11, "Find_Next_Object_Instance";
        /// Only as the response byte 0x94.
        ERROR_RESPONSE = 0x14, "Error_Response";
        RESTORE = 0x15, "Restore";
        SAVE = 0x16, "Save";
        NO_OPERATION = 0x17, "No_Operation";
        GET_MEMBER = 0x18, "Get_Member";
        SET_MEMBER = 0x19, "Set_Member";
        INSERT_MEMBER = 0x1A, "Insert_Member";
        REMOVE_MEMBER = 0x1B, "Remove_Member";
        GROUP_SYNC = 0x1C, "GroupSync";
        GET_CONNECTION_POINT_MEMBER_LIST = 0x1D, "Get_Connection_Point_Member_List";
    }
}

/// Who defines a service code.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ServiceRange {
    /// 0x01-0x31: common to all classes.
    Common,
    /// 0x32-0x4A: the vendor of the device.
    VendorSpecific,
    /// 0x4B-0x63: the object class.
    ObjectSpecific,
    /// 0x00, 0x64-0x7F, and what does not fit into seven bits.
    Reserved,
}

impl ServiceCode {
    /// DeviceNet object (class 3): Allocate_Master/Slave_Connection_Set.
    pub const ALLOCATE: Self = Self(0x4B);
    /// DeviceNet object (class 3): Release_Master/Slave_Connection_Set.
    pub const RELEASE: Self = Self(0x4C);

    /// Splits a service byte into the code and whether bit 7 says that it is a response.
    pub const fn split(byte: u8) -> (Self, bool) {
        (Self(byte & !RESPONSE_BIT), byte & RESPONSE_BIT != 0)
    }

    /// True if the code has seven bits, as every code that was read has.
    pub const fn is_valid(self) -> bool {
        self.0 & RESPONSE_BIT == 0
    }

    /// The service byte of a request: the code, of which seven bits count, with bit 7 clear.
    pub const fn request_byte(self) -> u8 {
        self.0 & !RESPONSE_BIT
    }

    /// The service byte of a response: the code, of which seven bits count, with bit 7 set.
    pub const fn response_byte(self) -> u8 {
        self.0 | RESPONSE_BIT
    }

    /// True for the common services that change nothing.
    #[inline]
    pub const fn is_question(self) -> bool {
        matches!(
            self,
            Self::GET_ATTRIBUTE_SINGLE
                | Self::GET_ATTRIBUTES_ALL
                | Self::GET_ATTRIBUTE_LIST
                | Self::FIND_NEXT_OBJECT_INSTANCE
                | Self::GET_MEMBER
                | Self::NO_OPERATION
        )
    }

    /// Who defines the code.
    pub const fn range(self) -> ServiceRange {
        match self.0 {
            0x01..=0x31 => ServiceRange::Common,
            0x32..=0x4A => ServiceRange::VendorSpecific,
            0x4B..=0x63 => ServiceRange::ObjectSpecific,
            0x00 | 0x64..=0xFF => ServiceRange::Reserved,
        }
    }
}

const RESPONSE_BIT: u8 = 0x80;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_meet_at_their_borders() {
        let borders = [
            (0x00, ServiceRange::Reserved),
            (0x01, ServiceRange::Common),
            (0x31, ServiceRange::Common),
            (0x32, ServiceRange::VendorSpecific),
            (0x4A, ServiceRange::VendorSpecific),
            (0x4B, ServiceRange::ObjectSpecific),
            (0x63, ServiceRange::ObjectSpecific),
            (0x64, ServiceRange::Reserved),
            (0x7F, ServiceRange::Reserved),
        ];
        for (code, range) in borders {
            assert_eq!(ServiceCode(code).range(), range, "0x{code:02X}");
        }
    }

    #[test]
    fn every_named_service_is_a_common_one() {
        for code in ServiceCode::NAMED {
            assert_eq!(code.range(), ServiceRange::Common, "{code}");
        }
    }

    #[test]
    fn every_byte_splits_and_joins() {
        for byte in 0..=u8::MAX {
            let (code, response) = ServiceCode::split(byte);
            assert_eq!(if response { code.response_byte() } else { code.request_byte() }, byte);
            assert!(code.is_valid());
            assert_eq!(ServiceCode(byte).is_valid(), !response);
        }
    }
}
