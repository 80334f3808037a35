#include "balance/spec/read_tolerances.hpp"

#include "balance/spec/reading.hpp"
#include "balance/spec/text_file.hpp"

#include <utility>

namespace balance {

TolerancedDesignSpace read_toleranced_space(const std::string& text, const std::string& file_name,
                                            const ReadOptions& options) {
  specification::ReadResult reading = specification::read_study(text, file_name, options.set);
  Tolerances tolerances = reading.start.tolerances;
  return {{std::move(reading.start), std::move(reading.recording)}, std::move(tolerances)};
}

TolerancedDesignSpace read_toleranced_space_file(const std::string& path, const ReadOptions& options) {
  return read_toleranced_space(read_text_file(path, "spec"), display_name(path), options);
}

}  // namespace balance
