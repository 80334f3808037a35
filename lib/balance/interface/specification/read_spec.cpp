#include "balance/interface/specification/read_spec.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/interface/specification/part_insertion.hpp"
#include "balance/interface/specification/read_document.hpp"
#include "balance/interface/specification/spec_units.hpp"
#include "balance/interface/specification/text_file.hpp"
#include "balance/interface/specification/yaml_document.hpp"

#include <utility>

namespace balance::specification {

SpecDocument::SpecDocument(std::string text) : text_(std::move(text)) {
  SpecErrorCollector problems("");
  try {
    auto root = std::make_shared<const YamlNode>(parse_yaml(text_, problems));
    if (problems.is_empty()) root_ = std::move(root);
  } catch (const ReadError&) {
    // without a root, reading parses the text again and rejects it
  } catch (const SpecError&) {
  }
}

Study read_spec(const SpecDocument& document, const std::string& file_name, const ReadOptions& options) {
  return read_start_study(document.text(), document.root(), file_name, options.set);
}

Study read_spec(const std::string& text, const std::string& file_name, const ReadOptions& options) {
  return read_start_study(text, nullptr, file_name, options.set);
}

Study read_spec_file(const std::string& path, const ReadOptions& options) {
  return read_spec(read_text_file(path, "spec"), display_name(path), options);
}

DesignSpace read_design_space(const std::string& text, const std::string& file_name, const ReadOptions& options) {
  ReadResult reading = read_study(text, file_name, options.set, options.inputs);
  return {std::move(reading.start), std::move(reading.recording)};
}

DesignSpace read_design_space_file(const std::string& path, const ReadOptions& options) {
  return read_design_space(read_text_file(path, "spec"), display_name(path), options);
}

TolerancedDesignSpace read_toleranced_space(const std::string& text, const std::string& file_name,
                                            const ReadOptions& options) {
  ReadResult reading = read_study(text, file_name, options.set);
  Tolerances tolerances = reading.start.tolerances;
  return {{std::move(reading.start), std::move(reading.recording)}, std::move(tolerances)};
}

TolerancedDesignSpace read_toleranced_space_file(const std::string& path, const ReadOptions& options) {
  return read_toleranced_space(read_text_file(path, "spec"), display_name(path), options);
}

namespace {

using specification::find_entry;
using specification::YamlNode;

void collect(const YamlNode& node, const std::string& path, study::SpecNumberTexts& texts) {
  if (node.kind == YamlNode::Kind::scalar) texts.numbers[path] = node.text;
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    const bool map = node.kind == YamlNode::Kind::map;
    const std::string key = map ? (path.empty() ? "" : ".") + node.keys[i].text : "[" + std::to_string(i) + "]";
    collect(node.items[i], path + key, texts);
  }
}

/// A free number's start is the middle of its bounds unless it is given.
std::string value_text(const YamlNode& value) {
  if (value.kind == YamlNode::Kind::scalar) return value.text;
  if (const YamlNode* start = find_entry(value, "start")) return start->text;
  const YamlNode* bounds = find_entry(value, "free");
  if (bounds == nullptr || bounds->items.size() != 2) return "";
  return "(" + bounds->items[0].text + " + " + bounds->items[1].text + ") / 2";
}

}  // namespace

study::SpecNumberTexts read_spec_number_texts(const DesignSpace& space, const ReadOptions& options) {
  study::SpecNumberTexts texts;
  texts.recording = space.recording;
  SpecErrorCollector problems("");
  const YamlNode root = parse_yaml(space.start.spec_text, problems);
  collect(root, "", texts);
  if (const YamlNode* section = find_entry(root, "parameters");
      section != nullptr && section->kind == YamlNode::Kind::map)
    for (std::size_t i = 0; i < section->items.size(); ++i)
      texts.parameters.push_back({section->keys[i].text, value_text(section->items[i])});
  for (const auto& [name, value] : options.set) {
    texts.numbers[name] = value;
    for (study::ParameterText& parameter : texts.parameters)
      if (parameter.name == name) parameter.text = value;
  }
  return texts;
}

SpecUnits read_display_units(const std::string& spec_text) {
  const SpecDocument document(spec_text);
  const YamlNode* units = document.root() == nullptr ? nullptr : find_entry(*document.root(), "units");
  if (units == nullptr) return {};
  SpecErrorCollector problems("");
  try {
    const Units read = read_units(SpecCursor(*units, "units", problems));
    return static_cast<const SpecUnits&>(read);  // what messages need besides is not displayed
  } catch (const ReadError&) {
    return {};
  }
}

NumberUnits list_number_units(const Study& study) {
  NumberUnits units;
  for (const auto& [path, dimension] : read_number_dimensions(study.spec_text, study.spec_file, study.overrides))
    units[path] = unit_of_dimension(dimension);
  return units;
}

}  // namespace balance::specification
