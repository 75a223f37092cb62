//! Plan, execute, cache, keys, manifest, events, progress; the only user of threads.
