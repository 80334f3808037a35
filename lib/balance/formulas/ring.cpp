#include "balance/formulas/ring.hpp"

#include <algorithm>

namespace balance::formulas {

namespace {

/// a + sign · b.
std::vector<std::pair<int, int>> sum_of(const std::vector<std::pair<int, int>>& a,
                                        const std::vector<std::pair<int, int>>& b, int sign) {
  std::vector<std::pair<int, int>> sum;
  std::size_t i = 0, j = 0;
  while (i < a.size() || j < b.size()) {
    const bool left = j == b.size() || (i < a.size() && a[i].first <= b[j].first);
    const bool right = i == a.size() || (j < b.size() && b[j].first <= a[i].first);
    const int angle = left ? a[i].first : b[j].first;
    const int multiple = (left ? a[i].second : 0) + (right ? sign * b[j].second : 0);
    if (multiple != 0) sum.emplace_back(angle, multiple);
    i += left ? 1 : 0;
    j += right ? 1 : 0;
  }
  return sum;
}

/// A product of two circular functions of one run, as a sum of two.
struct ProductToSumTerm {
  CircularFunction function;
  Rational factor;
};

ProductToSumTerm product_to_sum(const CircularFunction& a, const CircularFunction& b, int sign) {
  ProductToSumTerm half{{a.group, a.is_sine != b.is_sine, sum_of(a.argument, b.argument, sign)}, Rational(1, 2)};
  // sin a sin b = (cos(a − b) − cos(a + b)) / 2, cos a sin b = (sin(a + b) − sin(a − b)) / 2
  if ((a.is_sine && b.is_sine && sign > 0) || (!a.is_sine && b.is_sine && sign < 0)) half.factor = Rational(-1, 2);
  return half;
}

}  // namespace

Ring::Ring() : waves_(1), numbers_{{TrigonometricMonomial{}, 0}} {}

bool Ring::has_name(const std::string& name) const {
  const auto same = [&](const auto& other) { return other.name == name; };
  return std::any_of(symbols_.begin(), symbols_.end(), same) || std::any_of(angles_.begin(), angles_.end(), same);
}

int Ring::add_symbol(const std::string& name, SymbolKind kind, const Expression& source) {
  if (static_cast<int>(symbols_.size()) >= max_symbols)
    throw FormulaError("there are more than " + std::to_string(max_symbols) + " symbols");
  std::string free = name;
  while (has_name(free)) free += '_';
  symbols_.push_back({free, kind, source.value(), source});
  return static_cast<int>(symbols_.size()) - 1;
}

int Ring::add_angle(const std::string& name, int run) {
  std::string free = name;
  while (has_name(free)) free += '_';
  angles_.push_back({free, run, false, 0, {}});
  return static_cast<int>(angles_.size()) - 1;
}

int Ring::add_fixed_angle(const std::string& name, int run, const Expression& source) {
  const int angle = add_angle(name, run);
  Angle& fixed = angles_.back();
  fixed.is_fixed = true, fixed.value = source.value(), fixed.source = source;
  return angle;
}

int Ring::symbol_of_angle(int angle) {
  const std::string& name = angles_[static_cast<std::size_t>(angle)].name;
  const auto known =
      std::find_if(symbols_.begin(), symbols_.end(), [&](const Symbol& symbol) { return symbol.name == name; });
  if (known != symbols_.end()) return static_cast<int>(known - symbols_.begin());
  symbols_.push_back({name, SymbolKind::slide, 0, {}});
  return static_cast<int>(symbols_.size()) - 1;
}

TrigonometricId Ring::canonicalise(TrigonometricMonomial wave, Rational& factor) {
  TrigonometricMonomial tidy;
  for (CircularFunction& function : wave) {
    if (function.argument.empty()) {
      if (function.is_sine) factor = Rational(0);
      continue;
    }
    if (function.argument.front().second < 0) {
      for (auto& [angle, multiple] : function.argument) multiple = -multiple;
      if (function.is_sine) factor = -factor;
    }
    tidy.push_back(std::move(function));
  }
  std::sort(tidy.begin(), tidy.end());
  const auto [at, fresh] = numbers_.try_emplace(tidy, static_cast<TrigonometricId>(waves_.size()));
  if (fresh) {
    if (static_cast<int>(waves_.size()) >= max_trigonometric_monomials)
      throw FormulaError("they are too long; a program (--code) is not");
    waves_.push_back(std::move(tidy));
  }
  return at->second;
}

const std::vector<TrigonometricTerm>& Ring::product(TrigonometricId a, TrigonometricId b) {
  if (a > b) std::swap(a, b);
  const auto [at, fresh] = products_.try_emplace({a, b});
  if (!fresh) return at->second;
  struct Partial {
    TrigonometricMonomial wave;
    Rational factor = 1;
  };
  std::vector<Partial> parts(1), next;
  const TrigonometricMonomial left = waves_[a], right = waves_[b];
  std::size_t i = 0, j = 0;
  while (i < left.size() || j < right.size()) {
    const bool from_left = j == right.size() || (i < left.size() && left[i].group <= right[j].group);
    const bool from_right = i == left.size() || (j < right.size() && right[j].group <= left[i].group);
    next.clear();
    for (Partial& part : parts) {
      if (!(from_left && from_right)) {
        part.wave.push_back(from_left ? left[i] : right[j]);
        next.push_back(part);
        continue;
      }
      for (const int sign : {1, -1}) {
        const ProductToSumTerm half = product_to_sum(left[i], right[j], sign);
        next.push_back(part);
        next.back().wave.push_back(half.function);
        next.back().factor = part.factor * half.factor;
      }
    }
    parts.swap(next);
    i += from_left ? 1 : 0;
    j += from_right ? 1 : 0;
  }
  for (Partial& part : parts) {
    TrigonometricTerm found{0, part.factor};
    found.wave = canonicalise(std::move(part.wave), found.factor);
    if (found.factor.sign() != 0) at->second.push_back(found);
  }
  return at->second;
}

TrigonometricTerm Ring::derivative(TrigonometricId wave, int angle) {
  TrigonometricMonomial turned = waves_[wave];
  for (CircularFunction& function : turned)
    for (const auto& [variable, multiple] : function.argument)
      if (variable == angle) {
        TrigonometricTerm found{0, function.is_sine ? Rational(multiple) : Rational(-multiple)};
        function.is_sine = !function.is_sine;
        found.wave = canonicalise(std::move(turned), found.factor);
        return found;
      }
  return {0, 0};
}

}  // namespace balance::formulas
