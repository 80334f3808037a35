#include "balance/spec/read_spec.hpp"

#include "balance/base/error.hpp"
#include "balance/spec/reading.hpp"
#include "balance/spec/text_file.hpp"

namespace balance {

SpecDocument::SpecDocument(std::string text) : text_(std::move(text)) {
  specification::SpecErrorCollector problems("");
  try {
    auto root = std::make_shared<const specification::YamlNode>(specification::parse_yaml(text_, problems));
    if (problems.is_empty()) root_ = std::move(root);
  } catch (const specification::ReadError&) {
    // without a root the text is parsed, and refused, by whoever reads it
  } catch (const SpecError&) {
  }
}

Study read_spec(const SpecDocument& document, const std::string& file_name, const ReadOptions& options) {
  return specification::read_start_study(document.text(), document.root(), file_name, options.set);
}

Study read_spec(const std::string& text, const std::string& file_name, const ReadOptions& options) {
  return specification::read_start_study(text, nullptr, file_name, options.set);
}

Study read_spec_file(const std::string& path, const ReadOptions& options) {
  return read_spec(read_text_file(path, "spec"), display_name(path), options);
}

DesignSpace read_design_space(const std::string& text, const std::string& file_name, const ReadOptions& options) {
  specification::ReadResult reading = specification::read_study(text, file_name, options.set);
  return {std::move(reading.start), std::move(reading.recording)};
}

DesignSpace read_design_space_file(const std::string& path, const ReadOptions& options) {
  return read_design_space(read_text_file(path, "spec"), display_name(path), options);
}

}  // namespace balance
