#pragma once
/// How HDF5 reaches the disk here: through a descriptor that is open already, and without ever hearing of a failure.
///
/// HDF5 cannot let go of a file that it failed to write: it keeps its memory and crashes when the program ends. This
/// driver notes the first failure and pretends from then on that all is well; whoever writes looks at the note.

#include "balance/hdf5/handle.hpp"

namespace balance::hdf5 {

/// Must outlive the files that use it: HDF5 still looks at it after it closed the last one.
Hdf5Handle register_file_driver();

/// @param descriptor open for reading and writing an empty file; not closed here
/// @param error becomes the system's error number when something fails; must outlive the file
/// @return a file access list; the name given to H5Fcreate with it is only a name
Hdf5Handle make_file_access_list(const Hdf5Handle& driver, int descriptor, int& error);

}  // namespace balance::hdf5
