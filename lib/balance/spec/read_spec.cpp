#include "balance/spec/read_spec.hpp"

#include "balance/base/error.hpp"
#include "balance/spec/reading.hpp"
#include "balance/spec/text_file.hpp"

#include <fmt/format.h>

#include <memory>
#include <stdexcept>

namespace balance {

Study read_spec(const std::string& text, const std::string& file_name, const ReadOptions& options) {
  return read::read_first(text, file_name, options.set).start;
}

Study read_spec_file(const std::string& path, const ReadOptions& options) {
  return read_spec(read_text_file(path, "spec"), shown_name(path), options);
}

DesignSpace read_design_space(const std::string& text, const std::string& file_name, const ReadOptions& options) {
  const auto reading = std::make_shared<const read::Reading>(read::read_first(text, file_name, options.set));
  const auto at = [reading](const VectorX& x) {
    if (x.size() != static_cast<Eigen::Index>(reading->start.free_numbers.size()))
      throw std::invalid_argument(
          fmt::format("expected {} values of free numbers, found {}", reading->start.free_numbers.size(), x.size()));
    return read::read_again(*reading, x);
  };
  return {reading->start, at};
}

DesignSpace read_design_space_file(const std::string& path, const ReadOptions& options) {
  return read_design_space(read_text_file(path, "spec"), shown_name(path), options);
}

}  // namespace balance
