//! Codes of pass files, effects and measured data.

use super::codes;

codes! { PASS_CODES:
}
