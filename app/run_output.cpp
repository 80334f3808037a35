#include "run_output.hpp"

#include "console.hpp"
#include "signals.hpp"

#include "balance/write/json.hpp"
#include "balance/write/pending_file.hpp"
#include "balance/write/result_csv.hpp"
#include "balance/write/result_hdf5.hpp"
#include "balance/write/text.hpp"

namespace balance::app {

void print_run_header(const SimulateOptions& options, const Study& study, const Trajectory& trajectory) {
  if (options.quiet) return;
  for (const std::string& warning : study.warnings) print_message("warning: " + warning);
  if (options.trajectory.empty() && study.trajectories.size() > 1)
    print_message("note: no --trajectory given: '" + trajectory.name + "' is the first in the spec");
}

void print_notes(const SimulateOptions& options, const RunResult& result) {
  if (options.quiet) return;
  for (const std::string& text : result.outcome.notes) print_message("note: " + text);
}

std::vector<std::string> write_files(const SimulateOptions& options, const RunResult& result,
                                     const Provenance& description) {
  WriteOptions write;
  write.existing = options.force ? OverwritePolicy::replace : OverwritePolicy::forbid;
  write.compression = options.compress ? Compression::gzip : Compression::none;
  write.is_cancelled = [] { return pending_signal() != 0; };
  const SignalDeferral deferred;
  std::vector<std::string> files;
  if (!options.output.empty()) {
    write_result_hdf5(options.output, result, description, write);
    files.push_back(options.output);
  }
  if (!options.csv.empty()) {
    write_result_csv(options.csv, result, write);
    files.push_back(options.csv);
  }
  return files;
}

void print_result(const SimulateOptions& options, const RunResult& result, const Provenance& description,
                  const std::vector<std::string>& files) {
  if (options.spec.json) return print(format_result_json(result, description, files));
  if (options.quiet) return;
  std::string text = format_result_summary(result, description);
  for (const std::string& file : files) text += format_written_message(file);
  print_status(files, text);
}

}  // namespace balance::app
