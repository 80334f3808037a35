#include "run_files.hpp"

#include "signals.hpp"

#include "balance/write/result_csv.hpp"
#include "balance/write/result_hdf5.hpp"

namespace balance::app {

std::vector<std::string> write_files(const SimulateOptions& options, const Result& result,
                                     const FileDescription& description) {
  WriteOptions write;
  write.existing = options.force ? Existing::replace : Existing::keep;
  write.compression = options.compress ? Compression::gzip : Compression::none;
  write.cancelled = [] { return pending_signal() != 0; };
  const DeferSignals deferred;
  std::vector<std::string> files;
  if (!options.output.empty()) {
    write_result(options.output, result, description, write);
    files.push_back(options.output);
  }
  if (!options.csv.empty()) {
    write_csv(options.csv, result, write);
    files.push_back(options.csv);
  }
  return files;
}

}  // namespace balance::app
