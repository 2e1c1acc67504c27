//! The lines of the objects that every node has.

use super::{Access, Entry, ObjectType};
use crate::error::Symptom;
use crate::ethernet::{MAX_ETHERNET_PAYLOAD, MAX_PROCESS_DATA};
use crate::pdo::{MAX_MAPPED, RECEIVE_CHANNELS};

use Access::{Constant, ReadOnly, ReadWrite};
use ObjectType::{Boolean, Bytes, Text, Unsigned};

/// The objects 0x1000 to 0x1FFF of every node, in the order of index and sub-index.
///
/// Types, ranges and access: the object templates of EPSG DS 301.
pub const STANDARD_ENTRIES: &[Entry] = &[
    Entry::new(0x1000, 0, "NMT_DeviceType_U32", Unsigned(4), Constant),
    Entry::new(0x1001, 0, "ERR_ErrorRegister_U8", Unsigned(1), ReadOnly),
    Entry::new(0x1003, 0, "ERR_History_ADOM, number", Unsigned(1), ReadWrite).within(0, 0),
    Entry::new(0x1003, 1, "ERR_History_ADOM", Bytes(20), ReadOnly).up_to_sub(HISTORY),
    Entry::new(0x1006, 0, "NMT_CycleLen_U32", Unsigned(4), ReadWrite).within(LEAST_CYCLE, u32::MAX).or_none(),
    Entry::new(0x1008, 0, "NMT_ManufactDevName_VS", Text(64), Constant),
    Entry::new(0x1009, 0, "NMT_ManufactHwVers_VS", Text(64), Constant),
    Entry::new(0x100A, 0, "NMT_ManufactSwVers_VS", Text(64), Constant),
    Entry::new(0x1018, 0, "NMT_IdentityObject_REC", Unsigned(1), Constant),
    Entry::new(0x1018, 1, "VendorId_U32", Unsigned(4), Constant),
    Entry::new(0x1018, 2, "ProductCode_U32", Unsigned(4), Constant),
    Entry::new(0x1018, 3, "RevisionNo_U32", Unsigned(4), Constant),
    Entry::new(0x1018, 4, "SerialNo_U32", Unsigned(4), Constant),
    Entry::new(0x1020, 0, "CFM_VerifyConfiguration_REC", Unsigned(1), Constant),
    Entry::new(0x1020, 1, "ConfDate_U32", Unsigned(4), ReadWrite),
    Entry::new(0x1020, 2, "ConfTime_U32", Unsigned(4), ReadWrite),
    Entry::new(0x1020, 3, "ConfId_U32", Unsigned(4), ReadWrite),
    Entry::new(0x1020, 4, "VerifyConfInvalid_BOOL", Boolean, ReadOnly),
    Entry::new(0x1030, 0, "NMT_InterfaceGroup_REC", Unsigned(1), Constant),
    Entry::new(0x1030, 1, "InterfaceIndex_U16", Unsigned(2), Constant),
    Entry::new(0x1030, 2, "InterfaceDescription_VSTR", Text(64), Constant),
    Entry::new(0x1030, 3, "InterfaceType_U8", Unsigned(1), Constant),
    Entry::new(0x1030, 4, "InterfaceMtu_U16", Unsigned(2), Constant),
    Entry::new(0x1030, 5, "InterfacePhysAddress_OSTR", Bytes(6), Constant),
    Entry::new(0x1030, 6, "InterfaceName_VSTR", Text(64), Constant),
    Entry::new(0x1030, 7, "InterfaceOperStatus_U8", Unsigned(1), ReadOnly),
    Entry::new(0x1030, 8, "InterfaceAdminState_U8", Unsigned(1), ReadOnly),
    Entry::new(0x1030, 9, "Valid_BOOL", Boolean, ReadOnly),
    Entry::new(0x1300, 0, "SDO_SequLayerTimeout_U32", Unsigned(4), ReadWrite),
    Entry::new(0x1400, 0, "PDO_RxCommParam_REC", Unsigned(1), Constant).up_to_index(0x1400 + RECEIVE - 1),
    Entry::new(0x1400, 1, "NodeID_U8", Unsigned(1), ReadWrite)
        .up_to_index(0x1400 + RECEIVE - 1)
        .within(0, 254),
    Entry::new(0x1400, 2, "MappingVersion_U8", Unsigned(1), ReadWrite).up_to_index(0x1400 + RECEIVE - 1),
    Entry::new(0x1600, 0, "PDO_RxMappParam_AU64, number", Unsigned(1), ReadWrite)
        .up_to_index(0x1600 + RECEIVE - 1)
        .within(0, MAPPED),
    Entry::new(0x1600, 1, "PDO_RxMappParam_AU64", Unsigned(8), ReadWrite)
        .up_to_index(0x1600 + RECEIVE - 1)
        .up_to_sub(LAST_MAPPED),
    Entry::new(0x1800, 0, "PDO_TxCommParam_REC", Unsigned(1), Constant),
    Entry::new(0x1800, 1, "NodeID_U8", Unsigned(1), ReadWrite).within(0, 0),
    Entry::new(0x1800, 2, "MappingVersion_U8", Unsigned(1), ReadWrite),
    Entry::new(0x1A00, 0, "PDO_TxMappParam_AU64, number", Unsigned(1), ReadWrite).within(0, MAPPED),
    Entry::new(0x1A00, 1, "PDO_TxMappParam_AU64", Unsigned(8), ReadWrite).up_to_sub(LAST_MAPPED),
    Entry::new(Symptom::Collision.object(), 0, "error counter", Unsigned(1), Constant).up_to_index(0x1C0F),
    Entry::new(Symptom::Collision.object(), 1, "CumulativeCnt_U32", Unsigned(4), ReadWrite)
        .up_to_index(0x1C0F),
    Entry::new(Symptom::Collision.object(), 2, "ThresholdCnt_U32", Unsigned(4), ReadOnly).up_to_index(0x1C0F),
    Entry::new(Symptom::Collision.object(), 3, "Threshold_U32", Unsigned(4), ReadWrite).up_to_index(0x1C0F),
    Entry::new(Symptom::LossOfLink.object(), 0, "DLL_CNLossOfLinkCum_U32", Unsigned(4), ReadWrite),
    Entry::new(0x1C13, 0, "DLL_CNSoCJitterRange_U32", Unsigned(4), ReadWrite),
    Entry::new(0x1C14, 0, "DLL_CNLossOfSocTolerance_U32", Unsigned(4), ReadWrite),
    Entry::new(0x1E40, 0, "NWL_IpAddrTable_REC", Unsigned(1), Constant),
    Entry::new(0x1E40, 1, "IfIndex_U16", Unsigned(2), Constant),
    Entry::new(0x1E40, 2, "Addr_IPAD", Unsigned(4), ReadOnly),
    Entry::new(0x1E40, 3, "NetMask_IPAD", Unsigned(4), ReadOnly),
    Entry::new(0x1E40, 4, "ReasmMaxSize_U16", Unsigned(2), ReadOnly),
    Entry::new(0x1E40, 5, "DefaultGateway_IPAD", Unsigned(4), ReadOnly),
    Entry::new(0x1F82, 0, "NMT_FeatureFlags_U32", Unsigned(4), Constant),
    Entry::new(0x1F83, 0, "NMT_EPLVersion_U8", Unsigned(1), Constant),
    Entry::new(0x1F8C, 0, "NMT_CurrNMTState_U8", Unsigned(1), ReadOnly),
    Entry::new(0x1F93, 0, "NMT_EPLNodeID_REC", Unsigned(1), Constant),
    Entry::new(0x1F93, 1, "NodeID_U8", Unsigned(1), ReadOnly),
    Entry::new(0x1F93, 2, "NodeIDByHW_BOOL", Boolean, ReadOnly),
    Entry::new(0x1F98, 0, "NMT_CycleTiming_REC", Unsigned(1), Constant),
    Entry::new(0x1F98, 1, "IsochrTxMaxPayload_U16", Unsigned(2), Constant),
    Entry::new(0x1F98, 2, "IsochrRxMaxPayload_U16", Unsigned(2), Constant),
    Entry::new(0x1F98, 3, "PResMaxLatency_U32", Unsigned(4), Constant),
    Entry::new(0x1F98, 4, "PReqActPayloadLimit_U16", Unsigned(2), ReadWrite).within(36, PROCESS_DATA),
    Entry::new(0x1F98, 5, "PResActPayloadLimit_U16", Unsigned(2), ReadWrite).within(36, PROCESS_DATA),
    Entry::new(0x1F98, 6, "ASndMaxLatency_U32", Unsigned(4), Constant),
    Entry::new(0x1F98, 7, "MultiplCycleCnt_U8", Unsigned(1), ReadWrite),
    Entry::new(0x1F98, 8, "AsyncMTU_U16", Unsigned(2), ReadWrite).within(300, PAYLOAD),
    Entry::new(0x1F98, 9, "Prescaler_U16", Unsigned(2), ReadWrite).within(0, 1000),
    Entry::new(0x1F99, 0, "NMT_CNBasicEthernetTimeout_U32", Unsigned(4), ReadWrite),
    Entry::new(0x1F9A, 0, "NMT_HostName_VSTR", Text(32), ReadWrite),
    Entry::new(0x1F9E, 0, "NMT_ResetCmd_U8", Unsigned(1), ReadWrite),
];

/// The least cycle length, µs: SoC, PReq, PRes and SoA of the shortest length at 100 Mbit/s, 5120 ns each with 640 ns of preamble
/// before and a gap of 960 ns behind it.
const LEAST_CYCLE: u32 = (4 * (5120 + 640 + 960_u32)).div_ceil(1000);

/// Entries of the error history.
pub const HISTORY: u8 = 8;

// The same numbers in the types that a line needs; that they fit is part of a test.
const RECEIVE: u16 = 3;
const MAPPED: u32 = 32;
const LAST_MAPPED: u8 = 32;
const PROCESS_DATA: u32 = 1490;
const PAYLOAD: u32 = 1500;
const _: () = {
    assert!(RECEIVE_CHANNELS == 3 && MAX_MAPPED == 32);
    assert!(MAX_PROCESS_DATA == 1490 && MAX_ETHERNET_PAYLOAD == 1500);
};
