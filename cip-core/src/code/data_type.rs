//! Data type codes (CIP Vol. 1, appendix C) and the small numbers of old EDS files and Parameter objects.

super::codes! {
    /// The code of an elementary data type.
    ///
    /// Two sets are in use: 0xC1-0xDE, and the numbers 1-26 of old devices, named `OLD_*` here. Both are read;
    /// [`canonical`](Self::canonical) gives the one that is written.
    pub struct DataTypeCode(u8), "data type" in hex {
        BOOL = 0xC1, "BOOL";
        SINT = 0xC2, "SINT";
        INT = 0xC3, "INT";
        DINT = 0xC4, "DINT";
        LINT = 0xC5, "LINT";
        USINT = 0xC6, "USINT";
        UINT = 0xC7, "UINT";
        UDINT = 0xC8, "UDINT";
        ULINT = 0xC9, "ULINT";
        REAL = 0xCA, "REAL";
        LREAL = 0xCB, "LREAL";
        STIME = 0xCC, "STIME";
        DATE = 0xCD, "DATE";
        TIME_OF_DAY = 0xCE, "TIME_OF_DAY";
        DATE_AND_TIME = 0xCF, "DATE_AND_TIME";
        STRING = 0xD0, "STRING";
        BYTE = 0xD1, "BYTE";
        WORD = 0xD2, "WORD";
        DWORD = 0xD3, "DWORD";
        LWORD = 0xD4, "LWORD";
        STRING2 = 0xD5, "STRING2";
        FTIME = 0xD6, "FTIME";
        LTIME = 0xD7, "LTIME";
        ITIME = 0xD8, "ITIME";
        STRINGN = 0xD9, "STRINGN";
        SHORT_STRING = 0xDA, "SHORT_STRING";
        TIME = 0xDB, "TIME";
        EPATH = 0xDC, "EPATH";
        ENGUNIT = 0xDD, "ENGUNIT";
        STRINGI = 0xDE, "STRINGI";
        OLD_WORD = 1, "WORD";
        OLD_UINT = 2, "UINT";
        OLD_INT = 3, "INT";
        OLD_BOOL = 4, "BOOL";
        OLD_SINT = 5, "SINT";
        OLD_DINT = 6, "DINT";
        OLD_LINT = 7, "LINT";
        OLD_USINT = 8, "USINT";
        OLD_UDINT = 9, "UDINT";
        OLD_ULINT = 10, "ULINT";
        OLD_REAL = 11, "REAL";
        OLD_LREAL = 12, "LREAL";
        OLD_ITIME = 13, "ITIME";
        OLD_TIME = 14, "TIME";
        OLD_FTIME = 15, "FTIME";
        OLD_LTIME = 16, "LTIME";
        OLD_DATE = 17, "DATE";
        OLD_TIME_OF_DAY = 18, "TIME_OF_DAY";
        OLD_DATE_AND_TIME = 19, "DATE_AND_TIME";
        OLD_STRING = 20, "STRING";
        OLD_STRING2 = 21, "STRING2";
        OLD_STRINGN = 22, "STRINGN";
        OLD_SHORT_STRING = 23, "SHORT_STRING";
        OLD_BYTE = 24, "BYTE";
        OLD_DWORD = 25, "DWORD";
        OLD_LWORD = 26, "LWORD";
    }
}

impl DataTypeCode {
    /// The code of the set 0xC1-0xDE for the same type; a code of neither set is returned as it is.
    pub const fn canonical(self) -> Self {
        match self {
            Self::OLD_WORD => Self::WORD,
            Self::OLD_UINT => Self::UINT,
            Self::OLD_INT => Self::INT,
            Self::OLD_BOOL => Self::BOOL,
            Self::OLD_SINT => Self::SINT,
            Self::OLD_DINT => Self::DINT,
            Self::OLD_LINT => Self::LINT,
            Self::OLD_USINT => Self::USINT,
            Self::OLD_UDINT => Self::UDINT,
            Self::OLD_ULINT => Self::ULINT,
            Self::OLD_REAL => Self::REAL,
            Self::OLD_LREAL => Self::LREAL,
            Self::OLD_ITIME => Self::ITIME,
            Self::OLD_TIME => Self::TIME,
            Self::OLD_FTIME => Self::FTIME,
            Self::OLD_LTIME => Self::LTIME,
            Self::OLD_DATE => Self::DATE,
            Self::OLD_TIME_OF_DAY => Self::TIME_OF_DAY,
            Self::OLD_DATE_AND_TIME => Self::DATE_AND_TIME,
            Self::OLD_STRING => Self::STRING,
            Self::OLD_STRING2 => Self::STRING2,
            Self::OLD_STRINGN => Self::STRINGN,
            Self::OLD_SHORT_STRING => Self::SHORT_STRING,
            Self::OLD_BYTE => Self::BYTE,
            Self::OLD_DWORD => Self::DWORD,
            Self::OLD_LWORD => Self::LWORD,
            other => other,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_old_number_has_the_name_of_its_canonical_code() {
        for &code in DataTypeCode::NAMED {
            assert_eq!(code.name(), code.canonical().name());
            assert!(code.canonical().0 >= 0xC1);
        }
    }
}
