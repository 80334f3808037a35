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
struct Half {
  Circular function;
  Rational factor;
};

Half half_of(const Circular& a, const Circular& b, int sign) {
  Half half{{a.run, a.sine != b.sine, sum_of(a.argument, b.argument, sign)}, Rational(1, 2)};
  // sin a sin b = (cos(a − b) − cos(a + b)) / 2, cos a sin b = (sin(a + b) − sin(a − b)) / 2
  if ((a.sine && b.sine && sign > 0) || (!a.sine && b.sine && sign < 0)) half.factor = Rational(-1, 2);
  return half;
}

}  // namespace

Ring::Ring() : waves_(1), numbers_{{Wave{}, 0}} {}

bool Ring::is_taken(const std::string& name) const {
  const auto same = [&](const auto& other) { return other.name == name; };
  return std::any_of(symbols_.begin(), symbols_.end(), same) || std::any_of(angles_.begin(), angles_.end(), same);
}

int Ring::add_symbol(const std::string& name, SymbolKind kind, const Expression& source) {
  if (static_cast<int>(symbols_.size()) >= most_symbols)
    throw FormulaError("there are more than " + std::to_string(most_symbols) + " symbols");
  std::string free = name;
  while (is_taken(free)) free += '_';
  symbols_.push_back({free, kind, source.value(), source});
  return static_cast<int>(symbols_.size()) - 1;
}

int Ring::add_angle(const std::string& name, int run) {
  std::string free = name;
  while (is_taken(free)) free += '_';
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

WaveId Ring::find(Wave wave, Rational& factor) {
  Wave tidy;
  for (Circular& function : wave) {
    if (function.argument.empty()) {
      if (function.sine) factor = Rational(0);
      continue;
    }
    if (function.argument.front().second < 0) {
      for (auto& [angle, multiple] : function.argument) multiple = -multiple;
      if (function.sine) factor = -factor;
    }
    tidy.push_back(std::move(function));
  }
  std::sort(tidy.begin(), tidy.end());
  const auto [at, fresh] = numbers_.try_emplace(tidy, static_cast<WaveId>(waves_.size()));
  if (fresh) {
    if (static_cast<int>(waves_.size()) >= most_waves)
      throw FormulaError("they are too long; a program (--code) is not");
    waves_.push_back(std::move(tidy));
  }
  return at->second;
}

const std::vector<WavePart>& Ring::product(WaveId a, WaveId b) {
  if (a > b) std::swap(a, b);
  const auto [at, fresh] = products_.try_emplace({a, b});
  if (!fresh) return at->second;
  struct Partial {
    Wave wave;
    Rational factor = 1;
  };
  std::vector<Partial> parts(1), next;
  const Wave left = waves_[a], right = waves_[b];
  std::size_t i = 0, j = 0;
  while (i < left.size() || j < right.size()) {
    const bool from_left = j == right.size() || (i < left.size() && left[i].run <= right[j].run);
    const bool from_right = i == left.size() || (j < right.size() && right[j].run <= left[i].run);
    next.clear();
    for (Partial& part : parts) {
      if (!(from_left && from_right)) {
        part.wave.push_back(from_left ? left[i] : right[j]);
        next.push_back(part);
        continue;
      }
      for (const int sign : {1, -1}) {
        const Half half = half_of(left[i], right[j], sign);
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
    WavePart found{0, part.factor};
    found.wave = find(std::move(part.wave), found.factor);
    if (found.factor.sign() != 0) at->second.push_back(found);
  }
  return at->second;
}

WavePart Ring::derivative(WaveId wave, int angle) {
  Wave turned = waves_[wave];
  for (Circular& function : turned)
    for (const auto& [variable, multiple] : function.argument)
      if (variable == angle) {
        WavePart found{0, function.sine ? Rational(multiple) : Rational(-multiple)};
        function.sine = !function.sine;
        found.wave = find(std::move(turned), found.factor);
        return found;
      }
  return {0, 0};
}

}  // namespace balance::formulas
