#include "balance/spec/read_spec.hpp"

#include "balance/base/error.hpp"
#include "balance/spec/reading.hpp"
#include "balance/spec/text_file.hpp"

namespace balance {

SpecDocument::SpecDocument(std::string text) : text_(std::move(text)) {
  read::Problems problems("");
  try {
    auto root = std::make_shared<const read::Node>(read::parse_yaml(text_, problems));
    if (problems.none()) root_ = std::move(root);
  } catch (const read::Problem&) {
    // without a root the text is parsed, and refused, by whoever reads it
  } catch (const SpecError&) {
  }
}

Study read_spec(const SpecDocument& document, const std::string& file_name, const ReadOptions& options) {
  return read::read_start(document.text(), document.root(), file_name, options.set);
}

Study read_spec(const std::string& text, const std::string& file_name, const ReadOptions& options) {
  return read::read_start(text, nullptr, file_name, options.set);
}

Study read_spec_file(const std::string& path, const ReadOptions& options) {
  return read_spec(read_text_file(path, "spec"), shown_name(path), options);
}

DesignSpace read_design_space(const std::string& text, const std::string& file_name, const ReadOptions& options) {
  read::Reading reading = read::read_study(text, file_name, options.set);
  return {std::move(reading.start), std::move(reading.recording)};
}

DesignSpace read_design_space_file(const std::string& path, const ReadOptions& options) {
  return read_design_space(read_text_file(path, "spec"), shown_name(path), options);
}

}  // namespace balance
