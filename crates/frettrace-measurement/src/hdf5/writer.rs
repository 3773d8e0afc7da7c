//! Writing: beside the target first, renamed when whole, so that a failure leaves no half-written file.

use std::path::{Path, PathBuf};

use rust_hdf5::format::messages::datatype::CompoundMember;
use rust_hdf5::{
    ByteOrder, Complex64, DatatypeMessage, H5Dataset, H5File, H5Group, Hdf5Error, VarLenUnicode,
};
use tempfile::NamedTempFile;

use crate::error::Error;

/// Arrays of at least so many numbers are chunked and compressed.
const COMPRESSED_FROM: usize = 1024;
/// Chunk length along the first axis, a compromise between compression and partial reading.
const CHUNK: usize = 4096;
/// The fastest level of deflate compresses noise as well as slow ones, in less than half the time of level 2.
const DEFLATE_LEVEL: u32 = 1;

/// A file in the making.
pub(crate) struct FileWriter {
    target: PathBuf,
    temporary: NamedTempFile,
    file: H5File,
    compressed: bool,
}

/// A dataset to be written.
#[derive(Clone, Copy)]
pub(crate) struct NewArray<'a> {
    /// Length of every axis.
    pub(crate) shape: &'a [usize],
    /// The numbers, the last axis running fastest.
    pub(crate) values: &'a [f64],
    /// Units.
    pub(crate) units: &'a str,
}

/// A dataset written, to be made a dimension scale or to get one.
pub(crate) struct Written(H5Dataset);

impl FileWriter {
    /// Starts a file that will stand at `target`.
    pub(crate) fn create(target: &Path) -> Result<Self, Error> {
        let failed = |reason: String| Error::Write { file: target.to_path_buf(), reason };
        let folder =
            target.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let mut builder = tempfile::Builder::new();
        builder.prefix(".frettrace-").suffix(".part");
        // Readable as any file the user makes: the default of temporary files is private.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let temporary = builder.tempfile_in(folder).map_err(|error| failed(error.to_string()))?;
        let file = H5File::options().no_locking().create(temporary.path());
        let file = file.map_err(|error| failed(error.to_string()))?;
        Ok(Self { target: target.to_path_buf(), temporary, file, compressed: true })
    }

    /// Writes arrays as they are from now on: compressing a result would take longer than computing it.
    pub(crate) fn uncompressed(self) -> Self {
        Self { compressed: false, ..self }
    }

    /// Makes a group (its parents must exist).
    pub(crate) fn group(&self, place: &str) -> Result<(), Error> {
        let (parent, name) = split(place);
        self.done(self.parent(parent).and_then(|group| group.create_group(name)).map(drop))
    }

    /// Writes a text attribute of a group.
    pub(crate) fn text(&self, place: &str, name: &str, value: &str) -> Result<(), Error> {
        self.done(self.parent(place).and_then(|group| group.set_attr_string(name, value)))
    }

    /// Writes a number attribute of a group.
    pub(crate) fn number(&self, place: &str, name: &str, value: f64) -> Result<(), Error> {
        self.done(self.parent(place).and_then(|group| group.set_attr_numeric(name, &value)))
    }

    /// Writes an integer attribute of a group.
    pub(crate) fn integer(&self, place: &str, name: &str, value: i64) -> Result<(), Error> {
        self.done(self.parent(place).and_then(|group| group.set_attr_numeric(name, &value)))
    }

    /// Writes a dataset of doubles with its units.
    pub(crate) fn array(&self, place: &str, array: NewArray<'_>) -> Result<Written, Error> {
        self.done(self.write_array(place, array))
    }

    /// Writes a dataset of texts.
    pub(crate) fn texts(&self, place: &str, values: &[String]) -> Result<(), Error> {
        let (parent, name) = split(place);
        let texts: Vec<&str> = values.iter().map(String::as_str).collect();
        self.done(self.parent(parent).and_then(|group| group.write_vlen_strings(name, &texts)).map(drop))
    }

    /// Writes a complex dataset, as h5py does: a compound of doubles `r` and `i`.
    pub(crate) fn complex(
        &self,
        place: &str,
        real: NewArray<'_>,
        imaginary: &[f64],
    ) -> Result<Written, Error> {
        self.done(self.write_complex(place, real, imaginary))
    }

    /// Makes a dataset a dimension scale.
    pub(crate) fn scale(&self, scale: &Written, name: &str) -> Result<(), Error> {
        self.done(scale.0.set_scale(Some(name)))
    }

    /// Attaches a dimension scale to an axis of a dataset.
    pub(crate) fn attach(&self, dataset: &Written, axis: usize, scale: &Written) -> Result<(), Error> {
        self.done(dataset.0.attach_scale(axis, &scale.0))
    }

    /// Writes a text attribute of a dataset.
    pub(crate) fn describe(&self, dataset: &Written, name: &str, value: &str) -> Result<(), Error> {
        self.done(annotate(&dataset.0, name, value))
    }

    /// Closes the file and puts it in its place.
    pub(crate) fn finish(self) -> Result<(), Error> {
        let Self { target, temporary, file, .. } = self;
        let failed = |reason: String| Error::Write { file: target.clone(), reason };
        // Renamed when whole: a crash of the program leaves no half of it. Waiting for the disk would cost more than all else.
        file.close_no_sync().map_err(|error| failed(error.to_string()))?;
        temporary.persist(&target).map_err(|error| failed(error.error.to_string()))?;
        Ok(())
    }

    fn write_array(&self, place: &str, array: NewArray<'_>) -> Result<Written, Hdf5Error> {
        let (parent, name) = split(place);
        let builder = self.parent(parent)?.new_dataset::<f64>().shape(array.shape);
        let dataset = if self.compressed && array.values.len() >= COMPRESSED_FROM {
            let chunk: Vec<usize> = array
                .shape
                .iter()
                .enumerate()
                .map(|(axis, &n)| if axis == 0 { n.min(CHUNK) } else { n })
                .collect();
            builder.chunk(&chunk).shuffle_deflate(DEFLATE_LEVEL).create(name)?
        } else {
            builder.create(name)?
        };
        dataset.write_raw(array.values)?;
        annotate(&dataset, "units", array.units)?;
        Ok(Written(dataset))
    }

    fn write_complex(
        &self,
        place: &str,
        real: NewArray<'_>,
        imaginary: &[f64],
    ) -> Result<Written, Hdf5Error> {
        let (parent, name) = split(place);
        let member = |name: &str, offset| CompoundMember { name: name.into(), offset, datatype: double() };
        let members = vec![member("r", 0), member("i", 8)];
        let kind = DatatypeMessage::Compound { size: 16, members };
        let builder = self.parent(parent)?.new_dataset::<Complex64>().datatype(kind).shape(real.shape);
        let dataset = builder.create(name)?;
        let values: Vec<Complex64> =
            real.values.iter().zip(imaginary).map(|(&re, &im)| Complex64 { re, im }).collect();
        dataset.write_raw(&values)?;
        annotate(&dataset, "units", real.units)?;
        Ok(Written(dataset))
    }

    fn parent(&self, place: &str) -> Result<H5Group, Hdf5Error> {
        let root = self.file.root_group();
        let path = place.trim_matches('/');
        if path.is_empty() { Ok(root) } else { root.group(path) }
    }

    fn done<T>(&self, result: Result<T, Hdf5Error>) -> Result<T, Error> {
        result.map_err(|error| Error::Write { file: self.target.clone(), reason: error.to_string() })
    }
}

fn split(place: &str) -> (&str, &str) {
    place.rsplit_once('/').unwrap_or(("", place))
}

fn annotate(dataset: &H5Dataset, name: &str, value: &str) -> Result<(), Hdf5Error> {
    dataset.new_attr::<VarLenUnicode>().shape(()).create(name)?.write_string(value)
}

fn double() -> DatatypeMessage {
    DatatypeMessage::FloatingPoint {
        size: 8,
        byte_order: ByteOrder::LittleEndian,
        sign_location: 63,
        bit_offset: 0,
        bit_precision: 64,
        exponent_location: 52,
        exponent_size: 11,
        mantissa_location: 0,
        mantissa_size: 52,
        exponent_bias: 1023,
    }
}
