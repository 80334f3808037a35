#include "balance/write/result_hdf5.hpp"

#include "balance/hdf5/file.hpp"
#include "balance/write/pending_file.hpp"
#include "balance/write/result_group.hpp"

#include <stdexcept>

namespace balance {

void write_result(const std::string& path, const Result& result, const FileDescription& description,
                  const WriteOptions& options) {
  if (result.outcome.status != MotionStatus::done && description.controller.empty())
    throw std::invalid_argument("only a run that is done, or one under control, is written");
  if (result.time.size() == 0) throw std::invalid_argument("only a result with samples is written");
  PendingFile pending(path, options.existing, options.mark);
  const bool compress = options.compression == Compression::gzip;
  const auto storage = compress ? Hdf5File::Storage::compressed : Hdf5File::Storage::contiguous;
  {
    Hdf5File file(pending.descriptor(), path, storage);
    describe_source(file, description);
    describe_run(file, {}, description);
    if (!description.controller.empty()) describe_end(file, {}, result.outcome);
    add_result(file, {}, result, options);
    file.close();
  }  // others have their turn with HDF5 while this one waits for the disk
  stop_if_cancelled(options);
  pending.commit(options.durability);
}

}  // namespace balance
