#include "balance/spec/read_tolerances.hpp"

#include "balance/spec/reading.hpp"
#include "balance/spec/text_file.hpp"

#include <utility>

namespace balance {

TolerancedSpace read_toleranced(const std::string& text, const std::string& file_name, const ReadOptions& options) {
  read::Reading reading = read::read_study(text, file_name, options.set);
  Tolerances tolerances = reading.start.tolerances;
  return {{std::move(reading.start), std::move(reading.recording)}, std::move(tolerances)};
}

TolerancedSpace read_toleranced_file(const std::string& path, const ReadOptions& options) {
  return read_toleranced(read_text_file(path, "spec"), shown_name(path), options);
}

}  // namespace balance
