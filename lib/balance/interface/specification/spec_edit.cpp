#include "balance/interface/specification/spec_edit.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/specification/spec_units.hpp"
#include "balance/interface/specification/yaml_document.hpp"
#include "balance/interface/specification/yaml_source.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace balance::specification {

namespace {

struct Replacement {
  std::size_t begin = 0, end = 0;
  std::string text;
};

const YamlNode* find_value(const YamlNode& map, const std::string& key) {
  for (std::size_t i = 0; i < map.keys.size(); ++i)
    if (map.keys[i].text == key) return &map.items[i];
  return nullptr;
}

std::string format_key(const std::string& key) {
  return key.find('[') == std::string::npos && key.find('*') == std::string::npos ? key : quote_yaml(key);
}

/// "a: {b: value}" of the part of a path that is missing.
std::string format_entry(const std::vector<std::string>& path, std::size_t first, const std::string& value) {
  std::string text = value;
  for (std::size_t k = path.size(); k-- > first;) {
    text = format_key(path[k]) + ": " + text;
    if (k > first) text = "{" + text + "}";
  }
  return text;
}

class SpecEditor {
 public:
  explicit SpecEditor(const std::string& text)
      : text_(text), source_(text_), problems_(""), root_(parse_yaml(text_, problems_)) {}

  std::string apply(const std::vector<SpecEdit>& edits) {
    for (const SpecEdit& edit : edits) add(edit);
    std::stable_sort(replacements_.begin(), replacements_.end(),
                     [](const Replacement& a, const Replacement& b) { return a.begin < b.begin; });
    std::string result;
    std::size_t copied = 0;
    for (const Replacement& one : replacements_) {
      result += text_.substr(copied, one.begin - copied) + one.text;
      copied = one.end;
    }
    result += text_.substr(copied);
    if (!appended_.empty() && !result.empty() && result.back() != '\n') result += source_.line_break();
    return result + appended_;
  }

 private:
  void add(const SpecEdit& edit) {
    const YamlNode* node = &root_;
    for (std::size_t k = 0; k < edit.path.size(); ++k) {
      const YamlNode* child = find_value(*node, edit.path[k]);
      if (child == nullptr) return insert(*node, edit, k);
      if (child->alias != 0 || child->anchor != 0)
        throw SpecEditError(
            fmt::format("{} is an anchor or an alias, which other places of the spec share", join(edit.path, k)));
      node = child;
    }
    replace(*node, edit.value);
  }

  static std::string join(const std::vector<std::string>& path, std::size_t last) {
    std::string text;
    for (std::size_t k = 0; k <= last; ++k) text += (k == 0 ? "" : ".") + path[k];
    return quote_for_message(text);
  }

  /// A value of several lines becomes one of one line.
  void replace(const YamlNode& node, const std::string& value) {
    const Span span = source_.span(node);
    const bool is_tight =
        span.begin > 0 && std::string_view(" \t\r\n[{,").find(text_[span.begin - 1]) == std::string_view::npos;
    replacements_.push_back({span.begin, span.end, (is_tight ? " " : "") + value});
  }

  void insert(const YamlNode& map, const SpecEdit& edit, std::size_t first) {
    const std::string entry = format_entry(edit.path, first, edit.value);
    if (&map == &root_ && !root_.is_flow) {
      add_section(edit, first);
      return;
    }
    if (map.kind == YamlNode::Kind::null || map.keys.empty()) return replace(map, "{" + entry + "}");
    if (map.kind != YamlNode::Kind::map)
      throw SpecEditError(fmt::format("{} has another form", join(edit.path, first)));
    const std::size_t at = source_.span(map.keys.front()).begin;
    const std::string separator = map.is_flow ? ", " : source_.line_break() + source_.indentation(at);
    replacements_.push_back({at, at, entry + separator});
  }

  /// A new section at the end; several entries of one section follow each other.
  void add_section(const SpecEdit& edit, std::size_t first) {
    const std::string& section = edit.path[first];
    if (section != section_) appended_ += section + ":" + source_.line_break();
    section_ = section;
    appended_ += "  " + format_entry(edit.path, first + 1, edit.value) + source_.line_break();
  }

  const std::string text_;
  SourceText source_;
  SpecErrorCollector problems_;
  YamlNode root_;
  std::vector<Replacement> replacements_;
  std::string appended_, section_;
};

}  // namespace

std::string edit_spec(const std::string& text, const std::vector<SpecEdit>& edits) {
  return SpecEditor(text).apply(edits);
}

double read_force_unit(const std::string& text) {
  SpecErrorCollector problems("");
  const YamlNode root = parse_yaml(text, problems);
  const YamlNode* units = find_value(root, "units");
  return units == nullptr ? 1 : read_units(SpecCursor(*units, "units", problems)).factor(dimension::force);
}

std::string format_yaml_number(double value, int digits) {
  std::string text = fmt::format("{:.{}g}", value == 0 ? 0.0 : value, digits);
  const auto exponent = text.find('e');  // without a point YAML 1.1 sees no number
  if (exponent != std::string::npos && text.find('.') == std::string::npos) text.insert(exponent, ".0");
  return text;
}

}  // namespace balance::specification
