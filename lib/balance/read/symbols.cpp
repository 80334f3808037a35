#include "balance/read/symbols.hpp"

#include "balance/base/error.hpp"
#include "balance/spec/node.hpp"
#include "balance/spec/parameters.hpp"
#include "balance/spec/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace balance {

namespace {

using namespace read;

struct NamedParameter {
  std::string name;
  double value = 0;    ///< as written
  bool plain = false;  ///< a number or free; otherwise an expression over others
};

struct Vocabulary {
  std::vector<NamedParameter> parameters;  ///< none is zero
  double length = 1;                       ///< the spec's unit [m]
};

bool is_plain(const Node& node) { return node.kind == Node::Kind::map || names_in(node.text).values.empty(); }

const Node* find(const Node& map, const std::string& key) {
  for (std::size_t i = 0; i < map.keys.size(); ++i)
    if (map.keys[i].text == key) return &map.items[i];
  return nullptr;
}

/// The spec has been read before: nothing here is wrong.
Vocabulary read_vocabulary(const Study& study, const ReadOptions& options) {
  Problems problems(study.spec_file);
  const Node root = parse_yaml(study.spec_text, problems);
  Vocabulary result;
  if (const Node* units = find(root, "units")) result.length = read_units(Cursor(*units, "units", problems)).length;
  const Node* section = find(root, "parameters");
  if (section == nullptr) return result;
  Parameters parameters(Cursor(*section, "parameters", problems), options.set, nullptr, problems);
  for (std::size_t i = 0; i < section->keys.size(); ++i) {
    Node reference;
    reference.kind = Node::Kind::scalar;
    reference.text = section->keys[i].text;
    const double value = parameters.evaluate(Cursor(reference, reference.text, problems));
    bool plain = is_plain(section->items[i]);
    for (const auto& [name, text] : options.set)
      if (name == reference.text) plain = names_in(text).values.empty();
    if (value != 0) result.parameters.push_back({reference.text, value, plain});
  }
  return result;
}

/// How one geometric number follows one parameter.
struct Dependence {
  bool power = true;  ///< it follows a power of it, possibly the zeroth
  int exponent = 0;
};

Dependence dependence(double value, double up, double down) {
  if (up == value && down == value) return {};
  const double ratio = up / value, other = down / value;
  // Reading is exact but for the last digits.
  if (!(ratio > 0) || !(other > 0) || std::abs(ratio * other - 1) > 1e-12) return {false, 0};
  const double exponent = std::log(ratio / other) / (2 * std::log(probe_factor));
  const double whole = std::round(exponent);
  return std::abs(exponent - whole) < 1e-9 ? Dependence{true, static_cast<int>(whole)} : Dependence{false, 0};
}

/// All numbers' dependences on one parameter; nothing if the spec makes no sense with another value.
std::optional<std::vector<Dependence>> probe(const Study& study, const ReadOptions& options, const NamedParameter& p,
                                             const std::vector<GeometricNumber>& numbers) {
  const auto mechanism_at = [&](double factor) {
    ReadOptions changed = options;
    changed.set.emplace_back(p.name, fmt::format("{:.17g}", p.value * factor));
    return read_spec(study.spec_text, study.spec_file, changed).mechanism;
  };
  try {
    const Mechanism up = mechanism_at(probe_factor), down = mechanism_at(1 / probe_factor);
    std::vector<Dependence> result;
    for (const GeometricNumber& number : numbers)
      result.push_back(dependence(number.value, value_in(up, number), value_in(down, number)));
    return result;
  } catch (const SpecError&) {
    return std::nullopt;
  }
}

/// A number made of parameters: a small ratio times their powers.
using Powers = std::vector<std::pair<std::size_t, int>>;

class Namer {
 public:
  Namer(const Study& study, const ReadOptions& options)
      : vocabulary_(read_vocabulary(study, options)), numbers_(list_geometry(study.mechanism)) {
    for (const NamedParameter& p : vocabulary_.parameters) dependences_.push_back(probe(study, options, p, numbers_));
  }

  std::vector<Symbol> symbols() {
    const std::size_t count = vocabulary_.parameters.size();
    std::vector<Symbol> governing(count);
    for (std::size_t p = 0; p < count; ++p)
      governing[p] = {vocabulary_.parameters[p].name, "1", vocabulary_.parameters[p].value, {}};
    std::vector<std::pair<std::size_t, Powers>> made;
    for (std::size_t n = 0; n < numbers_.size(); ++n) {
      if (numbers_[n].value == 0) continue;
      const Powers powers = powers_of(n);
      if (!powers.empty()) made.emplace_back(n, powers);
    }
    for (const auto& [n, powers] : made)
      if (powers.size() == 1 && powers[0].second == 1) note_unit(governing[powers[0].first], numbers_[n]);
    std::set<std::size_t> governed;
    for (const auto& [n, powers] : made) {
      if (!is_simple(n, powers, governing)) continue;
      governed.insert(n);
      for (const auto& [p, exponent] : powers) governing[p].uses.push_back({numbers_[n], exponent});
    }
    std::erase_if(governing, [](const Symbol& symbol) { return symbol.uses.empty(); });
    for (std::size_t n = 0; n < numbers_.size(); ++n)
      if (worth_a_name(numbers_[n]) && governed.count(n) == 0) governing.push_back(own_symbol(numbers_[n]));
    return governing;
  }

 private:
  /// Of plain parameters if they explain the number altogether; else of one expression that the number is proportional to.
  Powers powers_of(std::size_t n) const {
    Powers plain, expressions;
    bool complete = true;
    for (std::size_t p = 0; p < vocabulary_.parameters.size(); ++p) {
      if (!dependences_[p]) continue;
      const Dependence& d = (*dependences_[p])[n];
      const bool is_plain_one = vocabulary_.parameters[p].plain;
      if (!d.power && is_plain_one) complete = false;
      if (!d.power || d.exponent == 0) continue;
      if (is_plain_one) plain.emplace_back(p, d.exponent);
      if (!is_plain_one && d.exponent == 1 && expressions.empty()) expressions.emplace_back(p, 1);
    }
    const double unit = numbers_[n].unit == "m" ? vocabulary_.length : 1;
    const auto explains = [&](const Powers& powers) {
      double product = unit;
      for (const auto& [p, e] : powers) product *= std::pow(vocabulary_.parameters[p].value, e);
      return !powers.empty() && as_small_ratio(numbers_[n].value / product).has_value();
    };
    if (complete && explains(plain)) return plain;
    return explains(expressions) ? expressions : Powers{};
  }

  /// A parameter that is a length is one in SI.
  void note_unit(Symbol& symbol, const GeometricNumber& number) const {
    if (symbol.unit != "1") return;
    symbol.unit = number.unit;
    if (number.unit == "m") symbol.value *= vocabulary_.length;
  }

  /// Whether a number is a small ratio of its symbols in SI too.
  bool is_simple(std::size_t n, const Powers& powers, const std::vector<Symbol>& symbols) const {
    double product = 1;
    for (const auto& [p, e] : powers) product *= std::pow(symbols[p].value, e);
    return as_small_ratio(numbers_[n].value / product).has_value();
  }

  /// A ratio of one is easier to read left out.
  static bool worth_a_name(const GeometricNumber& number) {
    return number.value != 0 && !(number.unit == "1" && std::abs(number.value) == 1);
  }

  Symbol own_symbol(const GeometricNumber& number) const {
    const auto taken = [&](const NamedParameter& p) { return p.name == number.label; };
    const auto& all = vocabulary_.parameters;
    const bool doubtful = std::any_of(all.begin(), all.end(), taken);
    return {doubtful ? "gravity" : number.label, number.unit, number.value, {{number, 1}}};
  }

  Vocabulary vocabulary_;
  std::vector<GeometricNumber> numbers_;
  std::vector<std::optional<std::vector<Dependence>>> dependences_;  // per parameter
};

}  // namespace

std::vector<Symbol> list_symbols(const Study& study, const ReadOptions& options) {
  try {
    return Namer(study, options).symbols();
  } catch (const Problem&) {
    // The spec's text is not what the study was read from: then nothing is known of its names.
    return own_symbols(study.mechanism);
  }
}

}  // namespace balance
