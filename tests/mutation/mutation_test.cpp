// Every key of every config spoilt in every way: refused with a place and the key's name, or right by its meaning.
// All of them with BALANCE_MUTATE_ALL in the environment, else a sample.

#include "balance/foundation/base/error.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/interface/specification/yaml_document.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <set>

namespace {

using namespace balance;
using balance::specification::YamlNode;
namespace fs = std::filesystem;

/// One way to spoil a value: by other text, or by taking it away.
struct Way {
  const char* name;
  const char* text;  ///< null: the key is taken away
};

constexpr Way ways[] = {{"missing", nullptr},     {"list", "[1, 2, 3, 4, 5]"}, {"mapping", "{zzz: 1}"},
                        {"negative", "-7"},       {"huge", "1e300"},           {"overflow", "1e999"},
                        {"not a number", ".nan"}, {"infinite", ".inf"},        {"unknown name", "zzz"},
                        {"unknown key", ""}};

std::string in_quotes(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) out += c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  return out + "\"";
}

/// The document with one node spoilt, sections on lines of their own.
std::string written(const YamlNode& node, const YamlNode* spoilt, const Way* way, bool top = false) {
  if (&node == spoilt && way->text[0] != '\0') return way->text;
  if (node.kind == YamlNode::Kind::null) return "~";
  if (node.kind == YamlNode::Kind::scalar) {
    const bool plain = node.text.find_first_of(",[]{}:#\"\x27&*!|>%@`") == std::string::npos;
    return node.is_quoted || !plain ? in_quotes(node.text) : node.text;
  }
  const bool map = node.kind == YamlNode::Kind::map;
  std::string text = map ? "{" : "[";
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    const bool here = &node.items[i] == spoilt;
    if (here && way->text == nullptr) continue;
    if (map) text += node.keys[i].text + (here && way->text[0] == '\0' ? "zzz: " : ": ");
    text += written(node.items[i], spoilt, way) + (top ? ",\n" : ", ");
  }
  return text + (map ? "}" : "]");
}

struct Value {
  const YamlNode* node;
  std::vector<std::string> path;  ///< keys down to it; "" an entry of a list
};

void list_values(const YamlNode& node, std::vector<std::string>& path, std::vector<Value>& all) {
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    path.push_back(node.kind == YamlNode::Kind::map ? node.keys[i].text : "");
    all.push_back({&node.items[i], path});
    list_values(node.items[i], path, all);
    path.pop_back();
  }
}

std::string name_of(const Value& value) {
  for (auto key = value.path.rbegin(); key != value.path.rend(); ++key)
    if (!key->empty()) return *key;
  return "";
}

/// Why the spoilt spec may be right after all; nothing: it may not.
std::optional<std::string> excuse(const Value& value, const std::string& way) {
  static const std::set<std::string> never_negative{"mass",        "duration", "samples",  "stiffness",
                                                    "free_length", "viscous",  "coulomb",  "ramp",
                                                    "ramps",       "seed",     "restarts", "seconds"};
  static const std::set<std::string> needed{"space",    "bodies", "joints", "mass",    "com",     "type",
                                            "connects", "drive",  "on",     "follows", "between", "stiffness",
                                            "ratio",    "centre", "via",    "free"};
  const std::string& section = value.path.front();
  const std::string name = name_of(value);
  const bool entry = value.path.back().empty();
  if (section == "name" && way != "list" && way != "mapping" && way != "unknown key") return "any text is a name";
  if (way == "negative" && never_negative.count(name) == 0) return "numbers of either sign";
  if (way == "huge") return "large numbers";
  if (way == "list" && value.node->kind == YamlNode::Kind::list && value.node->items.size() == 5)
    return "lists as long";
  if (way == "list" && value.path.size() == 3 && section == "design" && value.path[1] == "for")
    return "values of one's own";
  if (way == "missing" && entry) return "lists of other lengths";
  if (way == "missing" && !(needed.count(name) > 0 && value.path.size() != 2))
    return "keys with a default, names that nobody uses";
  // A disc may have no mass of its own; it turns once unless told otherwise.
  if (way == "missing" && section == "discs" && (name == "mass" || name == "ratio"))
    return "keys with a default, names that nobody uses";
  if (way == "unknown key" && !entry) return "names of one's own";
  if (way == "unknown key") return "nothing changed";
  return std::nullopt;
}

/// The message begins with file:line:column and names the key, the key it belongs to, or one of those that it held. What a parameter
/// makes impossible may also be told where it is used, by way of another parameter too.
bool is_good(const std::string& message, const Value& value, const std::string& way) {
  const std::size_t at = message.find(".yaml:");
  if (at == std::string::npos || message.find_first_not_of("0123456789:", at + 6) == at + 6) return false;
  const auto names = [&](const std::string& name) { return !name.empty() && message.find(name) != std::string::npos; };
  std::vector<std::string> keys = value.path;
  std::erase(keys, "");
  for (std::size_t i = 0; i < 2 && i < keys.size(); ++i)
    if (names(keys[keys.size() - 1 - i])) return true;
  if (way == "unknown key" && names("zzz")) return true;
  if (keys[0] == "parameters" && (names("inertia: no body can have") || names(", the value of '"))) return true;
  if (keys[0] == "workspace" && names("expected at least one range")) return true;  // of all joints together
  if (keys[0] == "joints" && way == "missing" && names("a chain of joints")) return true;
  // Without its parts, or with others, the whole misses their bodies.
  if (keys[0] == "include" && names("expected a body")) return true;
  return std::any_of(value.node->keys.begin(), value.node->keys.end(),
                     [&](const YamlNode& key) { return names(key.text); });
}

}  // namespace

TEST_CASE("a config with any key spoilt is refused by name or right by its meaning") {
  const bool all = std::getenv("BALANCE_MUTATE_ALL") != nullptr;
  const std::size_t stride = all ? 1 : 23;
  std::map<std::string, int> refused, right;
  std::size_t count = 0;
  std::vector<fs::path> configs;
  for (const auto& file : fs::directory_iterator(BALANCE_CONFIGS))
    if (file.path().extension() == ".yaml") configs.push_back(file.path());
  std::sort(configs.begin(), configs.end());
  for (const fs::path& config : configs) {
    std::ifstream in(config);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    balance::specification::SpecErrorCollector problems("");
    const YamlNode root = balance::specification::parse_yaml(text, problems);
    const std::string name = config.string();
    REQUIRE_NOTHROW(balance::read_spec(written(root, nullptr, nullptr, true), name));
    std::vector<Value> values;
    std::vector<std::string> path;
    list_values(root, path, values);
    for (const Value& value : values) {
      for (const Way& way : ways) {
        if (count++ % stride != 0) continue;
        const std::string spoilt = written(root, value.node, &way, true);
        std::string place;
        for (const std::string& key : value.path) place += "/" + key;
        CAPTURE(name);
        CAPTURE(place);
        const std::string kind = way.name;
        CAPTURE(kind);
        const std::clock_t begin = std::clock();
        try {
          balance::read_spec(spoilt, name);
          const auto why = excuse(value, way.name);
          CHECK_MESSAGE(why.has_value(), "it was read");
          ++right[way.name + std::string(": ") + why.value_or("?")];
        } catch (const SpecError& error) {
          const std::string message = error.what();
          CAPTURE(message);
          CHECK(is_good(message, value, kind));
          ++refused[way.name];
        }
        CHECK(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC < 1);
      }
    }
  }
  for (const auto& [way, number] : refused) MESSAGE(number << " refused: " << way);
  for (const auto& [why, number] : right) MESSAGE(number << " right: " << why);
  CHECK(count > 10'000);
}
