//! Vendor IDs, the few that are met most often. ODVA assigns them; 0 is not assigned.

super::codes! {
    /// The vendor of a device (Identity attribute 1).
    pub struct VendorId(u16), "vendor" in decimal {
        ROCKWELL = 1, "Rockwell Automation / Allen-Bradley";
        NAMCO = 2, "Namco Controls";
        HONEYWELL = 3, "Honeywell";
        PARKER_HANNIFIN = 4, "Parker Hannifin";
        RELIANCE_ELECTRIC = 5, "Rockwell/Reliance Electric";
        SMC = 7, "SMC";
        MOLEX = 8, "Molex (SST, Woodhead)";
        WESTERN_RESERVE_CONTROLS = 9, "Western Reserve Controls";
        ADVANCED_MICRO_CONTROLS = 10, "Advanced Micro Controls";
        ASCO = 11, "ASCO";
        BANNER = 12, "Banner Engineering";
        BELDEN = 13, "Belden";
        COOPER = 14, "Cooper Industries";
        DANIEL_WOODHEAD = 16, "Daniel Woodhead";
        DEARBORN = 17, "Dearborn Group";
        HELM = 19, "Helm Instrument";
        HURON_NETWORKS = 20, "Huron Networks";
        LUMBERG = 21, "Lumberg";
        ONLINE_DEVELOPMENT = 22, "Online Development";
        VORNE = 23, "Vorne Industries";
        ODVA = 24, "ODVA";
        FESTO = 26, "Festo";
        UNICO = 30, "Unico";
        MKS = 36, "MKS Instruments";
        WAGO = 40, "WAGO";
        ABB = 46, "ABB";
        OMRON = 47, "Omron";
        TURCK = 48, "Turck";
        HITACHI = 74, "Hitachi";
        HMS = 90, "HMS Industrial Networks";
        GRANVILLE_PHILLIPS = 92, "Granville-Phillips";
        BECKHOFF = 108, "Beckhoff";
        WATLOW = 153, "Watlow";
        SCHNEIDER = 243, "Schneider Electric";
        HILSCHER = 283, "Hilscher";
        VAT = 404, "VAT Vakuumventile";
        IAI = 699, "IAI";
        ICP_DAS = 803, "ICP DAS";
    }
}
