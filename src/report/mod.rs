//! Sections, plots, Markdown and HTML of the validation report; sees outputs and the manifest, never a solver.
