//! Class, instance and attribute IDs.

super::codes! {
    /// An object class.
    pub struct ClassId(u16), "class" in hex {
        IDENTITY = 0x01, "Identity";
        MESSAGE_ROUTER = 0x02, "Message Router";
        DEVICENET = 0x03, "DeviceNet";
        ASSEMBLY = 0x04, "Assembly";
        CONNECTION = 0x05, "Connection";
        CONNECTION_MANAGER = 0x06, "Connection Manager";
        REGISTER = 0x07, "Register";
        DISCRETE_INPUT_POINT = 0x08, "Discrete Input Point";
        DISCRETE_OUTPUT_POINT = 0x09, "Discrete Output Point";
        ANALOG_INPUT_POINT = 0x0A, "Analog Input Point";
        ANALOG_OUTPUT_POINT = 0x0B, "Analog Output Point";
        PRESENCE_SENSING = 0x0E, "Presence Sensing";
        PARAMETER = 0x0F, "Parameter";
        PARAMETER_GROUP = 0x10, "Parameter Group";
        GROUP = 0x12, "Group";
        DISCRETE_INPUT_GROUP = 0x1D, "Discrete Input Group";
        DISCRETE_OUTPUT_GROUP = 0x1E, "Discrete Output Group";
        DISCRETE_GROUP = 0x1F, "Discrete Group";
        ANALOG_INPUT_GROUP = 0x20, "Analog Input Group";
        ANALOG_OUTPUT_GROUP = 0x21, "Analog Output Group";
        ANALOG_GROUP = 0x22, "Analog Group";
        POSITION_SENSOR = 0x23, "Position Sensor";
        POSITION_CONTROLLER_SUPERVISOR = 0x24, "Position Controller Supervisor";
        POSITION_CONTROLLER = 0x25, "Position Controller";
        BLOCK_SEQUENCER = 0x26, "Block Sequencer";
        COMMAND_BLOCK = 0x27, "Command Block";
        MOTOR_DATA = 0x28, "Motor Data";
        CONTROL_SUPERVISOR = 0x29, "Control Supervisor";
        AC_DC_DRIVE = 0x2A, "AC/DC Drive";
        ACKNOWLEDGE_HANDLER = 0x2B, "Acknowledge Handler";
        OVERLOAD = 0x2C, "Overload";
        SOFTSTART = 0x2D, "Softstart";
        SELECTION = 0x2E, "Selection";
        S_DEVICE_SUPERVISOR = 0x30, "S-Device Supervisor";
        S_ANALOG_SENSOR = 0x31, "S-Analog Sensor";
        S_ANALOG_ACTUATOR = 0x32, "S-Analog Actuator";
        S_SINGLE_STAGE_CONTROLLER = 0x33, "S-Single Stage Controller";
        S_GAS_CALIBRATION = 0x34, "S-Gas Calibration";
        TRIP_POINT = 0x35, "Trip Point";
    }
}

super::codes! {
    /// An instance of a class. Instance 0 is the class itself.
    pub struct InstanceId(u16), "instance" in decimal {}
}

super::codes! {
    /// An attribute of an instance. One byte on the wire, except in a path with a 16-bit segment.
    pub struct AttributeId(u16), "attribute" in decimal {}
}

/// Who defines an ID of a class, an attribute or an assembly.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum IdRange {
    /// Defined by ODVA.
    Open,
    /// Defined by the vendor of the device.
    VendorSpecific,
    /// Nobody yet.
    Reserved,
}

impl ClassId {
    /// Who defines the class.
    pub const fn range(self) -> IdRange {
        match self.0 {
            0x01..=0x63 | 0x100..=0x2FF => IdRange::Open,
            0x64..=0xC7 | 0x300..=0x4FF => IdRange::VendorSpecific,
            0x00 | 0xC8..=0xFF | 0x500..=0xFFFF => IdRange::Reserved,
        }
    }
}

impl InstanceId {
    /// The class itself, which has attributes and services of its own.
    pub const CLASS: Self = Self(0);

    /// Who defines it, if it is an instance of the Assembly object: device profiles have 1-99 and 200-767, vendors
    /// 100-199 and 768-1279.
    pub const fn assembly_range(self) -> IdRange {
        match self.0 {
            1..=99 | 200..=767 => IdRange::Open,
            100..=199 | 768..=1279 => IdRange::VendorSpecific,
            0 | 1280..=0xFFFF => IdRange::Reserved,
        }
    }

    /// True for instance 0.
    pub const fn is_class(self) -> bool {
        self.0 == 0
    }
}

impl AttributeId {
    /// Who defines the attribute.
    pub const fn range(self) -> IdRange {
        match self.0 {
            0x00..=0x63 => IdRange::Open,
            0x64..=0xC7 => IdRange::VendorSpecific,
            0xC8..=0xFFFF => IdRange::Reserved,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_named_class_is_in_the_open_range() {
        for class in ClassId::NAMED {
            assert_eq!(class.range(), IdRange::Open, "{class}");
        }
        assert_eq!(ClassId(0x64).range(), IdRange::VendorSpecific);
        assert_eq!(ClassId(0xC8).range(), IdRange::Reserved);
        assert_eq!(ClassId(0x300).range(), IdRange::VendorSpecific);
        assert_eq!(AttributeId(100).range(), IdRange::VendorSpecific);
    }

    /// The first instance of each range.
    #[test]
    fn assembly_ranges_meet_at_their_borders() {
        use IdRange::{Open, Reserved, VendorSpecific};
        let borders = [
            (0, Reserved),
            (1, Open),
            (100, VendorSpecific),
            (200, Open),
            (768, VendorSpecific),
            (1280, Reserved),
        ];
        for (first, range) in borders {
            assert_eq!(InstanceId(first).assembly_range(), range, "{first}");
            let Some(before) = first.checked_sub(1) else { continue };
            assert_ne!(InstanceId(before).assembly_range(), range, "{before}");
        }
        assert_eq!(InstanceId(u16::MAX).assembly_range(), Reserved);
    }
}
