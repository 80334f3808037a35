#include "run_output.hpp"

#include "console.hpp"
#include "signals.hpp"

#include "balance/write/json.hpp"
#include "balance/write/pending_file.hpp"
#include "balance/write/result_csv.hpp"
#include "balance/write/result_hdf5.hpp"
#include "balance/write/text.hpp"

namespace balance::app {

void tell_what_is_run(const SimulateOptions& options, const Study& study, const Trajectory& trajectory) {
  if (options.quiet) return;
  for (const std::string& warning : study.warnings) tell("warning: " + warning);
  if (options.trajectory.empty() && study.trajectories.size() > 1)
    tell("note: no --trajectory given: '" + trajectory.name + "' is the first in the spec");
}

void tell_notes(const SimulateOptions& options, const Result& result) {
  if (options.quiet) return;
  for (const std::string& text : result.outcome.notes) tell("note: " + text);
}

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

void print_result(const SimulateOptions& options, const Result& result, const FileDescription& description,
                  const std::vector<std::string>& files) {
  if (options.spec.json) return print(result_json(result, description, files));
  if (options.quiet) return;
  std::string text = summary_text(result, description);
  for (const std::string& file : files) text += written_line(file);
  print_beside(files, text);
}

}  // namespace balance::app
