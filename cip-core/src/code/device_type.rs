//! Device types: the number of the device profile.

super::codes! {
    /// The device profile that a device follows (Identity attribute 2).
    pub struct DeviceType(u16), "device type" in hex {
        /// Newer devices use 0x2B.
        GENERIC = 0x00, "Generic device";
        AC_DRIVE = 0x02, "AC drive";
        MOTOR_OVERLOAD = 0x03, "Motor overload";
        LIMIT_SWITCH = 0x04, "Limit switch";
        INDUCTIVE_PROXIMITY_SWITCH = 0x05, "Inductive proximity switch";
        PHOTOELECTRIC_SENSOR = 0x06, "Photoelectric sensor";
        GENERAL_PURPOSE_DISCRETE_IO = 0x07, "General purpose discrete I/O";
        RESOLVER = 0x09, "Resolver";
        GENERAL_PURPOSE_ANALOG_IO = 0x0A, "General purpose analog I/O";
        COMMUNICATIONS_ADAPTER = 0x0C, "Communications adapter";
        PROGRAMMABLE_LOGIC_CONTROLLER = 0x0E, "Programmable logic controller";
        POSITION_CONTROLLER = 0x10, "Position controller";
        DC_DRIVE = 0x13, "DC drive";
        CONTACTOR = 0x15, "Contactor";
        MOTOR_STARTER = 0x16, "Motor starter";
        SOFT_START = 0x17, "Soft start";
        HUMAN_MACHINE_INTERFACE = 0x18, "Human-machine interface";
        MASS_FLOW_CONTROLLER = 0x1A, "Mass flow controller";
        PNEUMATIC_VALVE = 0x1B, "Pneumatic valve";
        VACUUM_PRESSURE_GAUGE = 0x1C, "Vacuum/pressure gauge";
        PROCESS_CONTROL_VALVE = 0x1D, "Process control valve";
        RESIDUAL_GAS_ANALYZER = 0x1E, "Residual gas analyzer";
        DC_POWER_GENERATOR = 0x1F, "DC power generator";
        RF_POWER_GENERATOR = 0x20, "RF power generator";
        TURBOMOLECULAR_VACUUM_PUMP = 0x21, "Turbomolecular vacuum pump";
        ENCODER = 0x22, "Encoder";
        SAFETY_DISCRETE_IO = 0x23, "Safety discrete I/O";
        FLUID_FLOW_CONTROLLER = 0x24, "Fluid flow controller";
        CIP_MOTION_DRIVE = 0x25, "CIP motion drive";
        COMPONET_REPEATER = 0x26, "CompoNet repeater";
        ENHANCED_MASS_FLOW_CONTROLLER = 0x27, "Mass flow controller, enhanced";
        SAFETY_ANALOG_IO = 0x2A, "Safety analog I/O";
        KEYABLE_GENERIC = 0x2B, "Generic device, keyable";
        MANAGED_SWITCH = 0x2C, "Managed switch";
        EMBEDDED_COMPONENT = 0xC8, "Embedded component";
    }
}

impl DeviceType {
    /// True for 0x64-0xC7, the profiles of vendors.
    pub const fn is_vendor_specific(self) -> bool {
        matches!(self.0, 0x64..=0xC7)
    }
}
