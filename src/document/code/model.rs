//! Codes of models.

use super::codes;

codes! { MODEL_CODES:
}
