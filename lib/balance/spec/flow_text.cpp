#include "balance/spec/flow_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

namespace balance::specification {

namespace {

bool is_word(char c) { return c == '_' || c == '.' || std::isalnum(static_cast<unsigned char>(c)) != 0; }

/// Whether it means itself without quotes, in a list in brackets too.
bool is_plain(const std::string& text) {
  if (text.empty() || text == "null" || text == "Null" || text == "NULL") return false;
  const bool sign = text[0] == '-' || text[0] == '+';
  const char first = sign && text.size() > 1 ? text[1] : text[0];
  if (!is_word(first) && first != '(') return false;
  if (text.rfind("...", 0) == 0) return false;
  return std::all_of(text.begin(), text.end(), [](char c) {
    return is_word(c) || std::string_view(" +-*/^()<>=").find(c) != std::string_view::npos;
  });
}

}  // namespace

std::string quote_yaml(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\')
      quoted += std::string("\\") + c;
    else if (byte < 0x20 || byte == 0x7f)
      quoted += fmt::format("\\x{:02x}", byte);
    else
      quoted += c;
  }
  return quoted + "\"";
}

std::string format_scalar(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r\n");
  if (first == std::string::npos) return "\"\"";
  const std::string trimmed = text.substr(first, text.find_last_not_of(" \t\r\n") - first + 1);
  return is_plain(trimmed) ? trimmed : quote_yaml(trimmed);
}

std::string format_flow(const YamlNode& node) {
  if (node.kind == YamlNode::Kind::null) return "~";
  if (node.kind == YamlNode::Kind::scalar) return node.is_quoted ? quote_yaml(node.text) : format_scalar(node.text);
  const bool map = node.kind == YamlNode::Kind::map;
  std::string text = map ? "{" : "[";
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    if (i > 0) text += ", ";
    if (map) text += format_scalar(node.keys[i].text) + ": ";
    text += format_flow(node.items[i]);
  }
  return text + (map ? "}" : "]");
}

}  // namespace balance::specification
