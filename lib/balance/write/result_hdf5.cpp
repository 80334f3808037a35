#include "balance/write/result_hdf5.hpp"

#include "balance/hdf5/file.hpp"
#include "balance/write/pending_file.hpp"
#include "balance/write/result_group.hpp"

#include <stdexcept>

namespace balance {

void write_result_hdf5(const std::string& path, const RunResult& result, const Provenance& description,
                       const WriteOptions& options) {
  if (result.outcome.status != MotionStatus::done && description.controller.empty())
    throw std::invalid_argument("only a run that is done, or one under control, is written");
  if (result.time.size() == 0) throw std::invalid_argument("only a result with samples is written");
  AtomicFile pending(path, options.existing, options.temporary_tag);
  const bool compress = options.compression == Compression::gzip;
  const auto storage = compress ? Hdf5Writer::Storage::compressed : Hdf5Writer::Storage::contiguous;
  {
    Hdf5Writer file(pending.descriptor(), path, storage);
    write_source_attributes(file, description);
    write_run_attributes(file, {}, description);
    if (!description.controller.empty()) write_outcome_attributes(file, {}, result.outcome);
    write_result_variables(file, {}, result, options);
    file.close();
  }  // others have their turn with HDF5 while this one waits for the disk
  throw_if_cancelled(options);
  pending.commit(options.durability);
}

}  // namespace balance
