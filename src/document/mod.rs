//! JSON with places: spans, quantities and units, checked maps, canonical form, hashes, diagnostics.
