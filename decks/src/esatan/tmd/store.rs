//! Datasets of an HDF5 file, read within bounds: sizes are looked at before anything is allocated.

use hdf5_reader::group::Group;
use hdf5_reader::{
    Dataset, Datatype, H5Type, Hdf5File, OpenOptions, SliceInfo, SliceInfoElem, StringSize, dtype_element_size,
};

/// Largest decoded part of a dataset that is held at once, in bytes.
const BLOCK_BYTES: u64 = 64 << 20;
/// Largest piece that the file itself may cut a dataset into, in bytes.
const CHUNK_BYTES: usize = 64 << 20;

/// Opens a file's bytes within bounds.
pub(super) fn open(bytes: &[u8]) -> hdf5_reader::error::Result<Hdf5File> {
    let options = OpenOptions::default()
        .with_chunk_cache_bytes(16 << 20)
        .with_max_chunk_bytes(CHUNK_BYTES)
        .with_max_read_bytes(BLOCK_BYTES as usize)
        .with_max_object_header_bytes(4 << 20);
    Hdf5File::from_bytes_with_options(bytes, options)
}

/// A string of fixed length as its bytes.
#[derive(Clone)]
pub(super) struct FixedText(Vec<u8>);

impl FixedText {
    /// Its text without the blanks or zeros that fill it up.
    pub(super) fn text(&self) -> String {
        trimmed(&self.0)
    }

    /// Its bytes as they stand.
    pub(super) fn bytes(&self) -> &[u8] {
        &self.0
    }

    /// Its first character; a blank if it has none.
    pub(super) fn first(&self) -> char {
        self.0.first().map_or(' ', |&byte| char::from(byte))
    }
}

impl H5Type for FixedText {
    fn hdf5_type() -> Datatype {
        Datatype::String {
            size: StringSize::Fixed(1),
            encoding: hdf5_reader::StringEncoding::Ascii,
            padding: hdf5_reader::StringPadding::SpacePad,
        }
    }

    fn from_bytes(bytes: &[u8], _dtype: &Datatype) -> hdf5_reader::error::Result<Self> {
        Ok(Self(bytes.to_vec()))
    }

    fn element_size(dtype: &Datatype) -> usize {
        dtype_element_size(dtype).unwrap_or(0)
    }
}

/// Text of a field of fixed length without the blanks or zeros that fill it up.
pub(super) fn trimmed(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(bytes.get(..end).unwrap_or_default()).trim().to_owned()
}

/// A dataset of a group with the sizes that the model's own tables call for; an error is a sentence's fragment.
pub(super) struct Table {
    name: String,
    dataset: Dataset,
    shape: Vec<usize>,
}

impl Table {
    /// Opens a dataset of `rank` dimensions, each at most `limits`.
    pub(super) fn open(group: &Group, name: &str, limits: &[usize]) -> Result<Self, String> {
        let dataset = group.dataset(name).map_err(|error| {
            format!("no dataset `{name}` in `{}` ({error}); write the file with the model in it", group.name())
        })?;
        let extent = dataset.shape();
        if extent.len() != limits.len() {
            return Err(format!("`{name}` has {} dimensions instead of {}", extent.len(), limits.len()));
        }
        let mut shape = Vec::with_capacity(extent.len());
        for (&size, &limit) in extent.iter().zip(limits) {
            match usize::try_from(size) {
                Ok(size) if size <= limit => shape.push(size),
                _ => return Err(format!("`{name}` has a dimension of {size}, more than the {limit} that are read")),
            }
        }
        Ok(Self { name: name.to_owned(), dataset, shape })
    }

    /// Sizes of its dimensions.
    pub(super) fn shape(&self) -> &[usize] {
        &self.shape
    }

    /// Checks a dimension against the table that determines it.
    pub(super) fn expect(&self, dimension: usize, size: usize, of: &str) -> Result<(), String> {
        match self.shape.get(dimension) {
            Some(&actual) if actual == size => Ok(()),
            actual => Err(format!("`{}` holds {} instead of the {size} of {of}", self.name, actual.unwrap_or(&0))),
        }
    }

    /// Visits its rows in order: `visit(row, values of the row)`.
    pub(super) fn each_row<T: H5Type>(
        &self,
        mut visit: impl FnMut(usize, &[T]) -> Result<(), String>,
    ) -> Result<(), String> {
        let Some((&rows, rest)) = self.shape.split_first() else { return Ok(()) };
        let width = rest.iter().try_fold(1_usize, |product, &size| product.checked_mul(size));
        // A value may be larger in memory than in the file: a text's bytes are counted too.
        let stored = self.dataset.raw_element_size().map_err(|error| self.fails(error))?;
        let size = std::mem::size_of::<T>().saturating_add(stored);
        let row_bytes = width.and_then(|width| width.checked_mul(size)).unwrap_or(usize::MAX);
        if row_bytes as u64 > BLOCK_BYTES {
            return Err(format!("a row of `{}` is larger than the {BLOCK_BYTES} bytes that are read", self.name));
        }
        let width = width.unwrap_or(0);
        if width == 0 || rows == 0 {
            return Ok(());
        }
        let chunk_rows = self.dataset.chunks().and_then(|chunks| chunks.first().copied()).unwrap_or(1).max(1) as usize;
        let fitting = (BLOCK_BYTES as usize / row_bytes.max(1)).clamp(1, rows);
        // Whole pieces of the file where they fit, so that none is unpacked twice.
        let step = if fitting >= chunk_rows { fitting / chunk_rows * chunk_rows } else { fitting };
        let mut start = 0;
        while start < rows {
            let end = start.saturating_add(step).min(rows);
            let mut selection = SliceInfo::all(self.shape.len());
            if let Some(first) = selection.selections.first_mut() {
                *first = SliceInfoElem::Slice { start: start as u64, end: end as u64, step: 1 };
            }
            let block = self.dataset.read_slice::<T>(&selection).map_err(|error| self.fails(error))?;
            let values: Vec<T> = block.iter().cloned().collect();
            if values.len() != (end - start) * width {
                return Err(format!("`{}` is shorter than its own size", self.name));
            }
            for (offset, row) in values.chunks_exact(width).enumerate() {
                visit(start + offset, row)?;
            }
            start = end;
        }
        Ok(())
    }

    /// All its values.
    pub(super) fn all<T: H5Type>(&self) -> Result<Vec<T>, String> {
        let mut values = Vec::new();
        self.each_row(|_, row: &[T]| {
            values.extend_from_slice(row);
            Ok(())
        })?;
        Ok(values)
    }

    fn fails(&self, error: hdf5_reader::error::Error) -> String {
        format!("`{}` cannot be read: {error}", self.name)
    }
}
