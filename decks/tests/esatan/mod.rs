//! Models of ESATAN and ESATAN-TMS: texts and dumps made up here, and a public result.

mod closure;
mod results;
mod texts;
