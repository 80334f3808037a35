#include "balance/synthesis/certificate/discrete_domain.hpp"

#include "balance/motion/study/different_numbers.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

namespace balance::certificate {
namespace {

/// Relative: a number that differs from a size or a bound by less is equal to it.
constexpr double size_tolerance = 1e-12;
/// Relative to the sum of all masses: a counterweight with less is not there.
constexpr double mass_tolerance = 1e-9;

using State = DesignPart::ElementState;

double margin_of(const std::vector<double>& sizes) {
  return size_tolerance * std::max(std::abs(sizes.front()), std::abs(sizes.back()));
}

/// Reduces an interval to the first and the last size in it. @return false if there is none
bool contract_to_sizes(const std::vector<double>& sizes, double& lower, double& upper) {
  const auto first = std::lower_bound(sizes.begin(), sizes.end(), lower - margin_of(sizes));
  const auto last = std::upper_bound(sizes.begin(), sizes.end(), upper + margin_of(sizes));
  if (first >= last) return false;
  lower = *first;
  upper = *std::prev(last);
  return true;
}

double nearest_size(const std::vector<double>& sizes, double value) {
  const auto above = std::lower_bound(sizes.begin(), sizes.end(), value);
  if (above == sizes.begin()) return sizes.front();
  if (above == sizes.end()) return sizes.back();
  return *above - value < value - *std::prev(above) ? *above : *std::prev(above);
}

}  // namespace

int count_min_elements(const std::vector<ElementChoice>& choices, const VectorX& x) {
  const auto is_kept = [&](const ElementChoice::Element& element) {
    return std::any_of(element.numbers.begin(), element.numbers.end(), [&](int number) { return x[number] != 0; });
  };
  int count = 0;
  for (const ElementChoice& choice : choices)
    if (choice.max_count < 0)
      count += static_cast<int>(std::count_if(choice.elements.begin(), choice.elements.end(), is_kept));
  return count;
}

DiscreteDomain::DiscreteDomain(const DesignSpace& space, const LengthGeometry& geometry, std::vector<int> lengths,
                               const std::vector<ElementChoice>& choices, int min_count)
    : space_(space), geometry_(geometry), lengths_(std::move(lengths)) {
  for (const FreeNumber& number : space.start.free_numbers) sizes_.push_back(number.discrete_values);
  restrict_sizes();
  std::optional<std::size_t> shared;
  for (const ElementChoice& choice : choices) {
    const bool is_least = choice.max_count < 0;
    const std::size_t group = is_least && shared ? *shared : groups_.size();
    if (group == groups_.size()) groups_.push_back(is_least ? min_count : choice.max_count);
    if (is_least) shared = group;
    for (const ElementChoice::Element& one : choice.elements) {
      Element element{{}, {}, one.numbers, one.own_numbers, group};
      for (const int number : one.numbers) {
        for (std::size_t i = 0; i < geometry.linkage.counterweights.size(); ++i)
          if (geometry.linkage.counterweights[i].mass_number == number)
            element.counterweights.push_back(static_cast<int>(i));
        if (std::find(lengths_.begin(), lengths_.end(), number) != lengths_.end()) element.lengths.push_back(number);
      }
      elements_.push_back(std::move(element));
    }
  }
}

void DiscreteDomain::restrict_sizes() {
  for (const auto& [number, value] : geometry_.substitution) {
    const std::vector<double>& own = space_.start.free_numbers[static_cast<std::size_t>(number)].discrete_values;
    if (own.empty()) continue;
    for (const int other : lengths_) {
      const auto difference = (value - LengthPolynomial::variable(geometry_.linkage.variables, other)).constant_value();
      if (!difference || *difference != LengthPolynomial::Coefficient(0)) continue;
      std::vector<double>& sizes = sizes_[static_cast<std::size_t>(other)];
      const auto is_own = [&](double size) { return std::abs(nearest_size(own, size) - size) <= margin_of(own); };
      if (sizes.empty())
        sizes = own;
      else
        std::erase_if(sizes, [&](double size) { return !is_own(size); });
      is_empty_ = is_empty_ || sizes.empty();
    }
  }
}

DesignPart DiscreteDomain::root() const {
  return {geometry_.box, list_mass_limits(geometry_.linkage), std::vector<State>(elements_.size(), State::undecided)};
}

bool DiscreteDomain::propagate_sizes(DesignPart& part) const {
  for (const int length : lengths_) {
    const std::vector<double>& sizes = sizes_[static_cast<std::size_t>(length)];
    if (!sizes.empty() && !contract_to_sizes(sizes, part.box.lower[length], part.box.upper[length])) return false;
  }
  for (std::size_t i = 0; i < part.masses.size(); ++i) {
    const int number = geometry_.linkage.counterweights[i].mass_number;
    if (number < 0 || sizes_[static_cast<std::size_t>(number)].empty()) continue;
    if (!contract_to_sizes(sizes_[static_cast<std::size_t>(number)], part.masses[i].lower, part.masses[i].upper))
      return false;
  }
  return true;
}

bool DiscreteDomain::propagate_element(DesignPart& part, std::size_t k) const {
  const Element& element = elements_[k];
  State& state = part.elements[k];
  if (!element.has_effect()) return true;
  bool is_zero = true, cannot_vanish = false;
  for (const int i : element.counterweights) {
    const MassLimits& mass = part.masses[static_cast<std::size_t>(i)];
    is_zero = is_zero && mass.is_left_out();
    cannot_vanish = cannot_vanish || mass.lower > 0;
  }
  for (const int length : element.lengths) {
    is_zero = is_zero && part.box.lower[length] == 0 && part.box.upper[length] == 0;
    cannot_vanish = cannot_vanish || part.box.lower[length] > 0 || part.box.upper[length] < 0;
  }
  if (is_zero && state == State::kept) return false;  // as if it were left out, which is another part
  if (is_zero) state = State::left_out;
  if (cannot_vanish && state == State::left_out) return false;
  if (cannot_vanish) state = State::kept;
  if (state != State::left_out) return true;
  for (const int i : element.counterweights) part.masses[static_cast<std::size_t>(i)].upper = 0;
  for (const int length : element.lengths) part.box.lower[length] = part.box.upper[length] = 0;
  return true;
}

bool DiscreteDomain::propagate_counts(DesignPart& part) const {
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    int kept = 0;
    for (std::size_t k = 0; k < elements_.size(); ++k)
      kept += elements_[k].group == g && part.elements[k] == State::kept ? 1 : 0;
    if (kept > groups_[g]) return false;
    if (kept < groups_[g]) continue;
    for (std::size_t k = 0; k < elements_.size(); ++k)
      if (elements_[k].group == g && part.elements[k] == State::undecided) part.elements[k] = State::left_out;
  }
  return true;
}

bool DiscreteDomain::propagate(DesignPart& part) const {
  if (is_empty_) return false;
  for (;;) {
    const std::vector<State> before = part.elements;
    if (!propagate_sizes(part) || !propagate_counts(part)) return false;
    for (std::size_t k = 0; k < elements_.size(); ++k)
      if (!propagate_element(part, k)) return false;
    if (part.elements == before) return true;
  }
}

double DiscreteDomain::max_mass(const DesignPart& part) const {
  std::vector<bool> is_optional(part.masses.size(), false);
  std::vector<std::vector<double>> undecided(groups_.size());
  std::vector<int> kept(groups_.size(), 0);
  double sum = 0;
  for (std::size_t k = 0; k < elements_.size(); ++k) {
    double upper = 0;
    for (const int i : elements_[k].counterweights) {
      if (is_optional[static_cast<std::size_t>(i)]) continue;
      is_optional[static_cast<std::size_t>(i)] = true;
      upper += std::max(0.0, part.masses[static_cast<std::size_t>(i)].upper);
    }
    if (part.elements[k] == State::undecided) undecided[elements_[k].group].push_back(upper);
    if (part.elements[k] != State::kept) continue;
    sum += upper;
    ++kept[elements_[k].group];
  }
  for (std::size_t i = 0; i < part.masses.size(); ++i)
    if (!is_optional[i]) sum += part.masses[i].upper;
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    std::sort(undecided[g].begin(), undecided[g].end(), std::greater<>());
    const auto count = std::min(undecided[g].size(), static_cast<std::size_t>(std::max(0, groups_[g] - kept[g])));
    sum = std::accumulate(undecided[g].begin(), undecided[g].begin() + static_cast<std::ptrdiff_t>(count), sum);
  }
  return sum;
}

std::vector<DesignPart> DiscreteDomain::divide_length(const DesignPart& part, int length) const {
  std::vector<DesignPart> halves(2, part);
  const std::vector<double>& sizes = sizes_[static_cast<std::size_t>(length)];
  const double middle = (part.box.lower[length] + part.box.upper[length]) / 2;
  halves[0].box.upper[length] = halves[1].box.lower[length] = middle;
  if (sizes.empty()) return halves;
  // both ends are sizes
  const auto above = std::upper_bound(sizes.begin(), sizes.end(), middle);
  halves[0].box.upper[length] = *std::prev(above);
  halves[1].box.lower[length] = *above;
  return halves;
}

std::vector<DesignPart> DiscreteDomain::divide_elements(const DesignPart& part, const VectorX& masses) const {
  const double threshold = mass_tolerance * std::max(1.0, masses.sum());
  std::vector<int> present(groups_.size(), 0);
  std::vector<double> amounts(elements_.size(), 0);
  for (std::size_t k = 0; k < elements_.size(); ++k) {
    for (const int i : elements_[k].counterweights) amounts[k] += masses[i];
    if (!elements_[k].lengths.empty()) amounts[k] += threshold;  // to be decided in any case
    if (part.elements[k] == State::kept || (part.elements[k] == State::undecided && amounts[k] >= threshold))
      ++present[elements_[k].group];
  }
  std::optional<std::size_t> chosen;
  for (std::size_t k = 0; k < elements_.size(); ++k)
    if (part.elements[k] == State::undecided && elements_[k].has_effect() && amounts[k] >= threshold &&
        present[elements_[k].group] > groups_[elements_[k].group] && (!chosen || amounts[k] > amounts[*chosen]))
      chosen = k;
  if (!chosen) return {};
  std::vector<DesignPart> parts(2, part);
  parts[0].elements[*chosen] = State::left_out;
  parts[1].elements[*chosen] = State::kept;
  return parts;
}

std::vector<DesignPart> DiscreteDomain::divide_masses(const DesignPart& part, const VectorX& masses,
                                                      double& distance) const {
  int chosen = -1;
  double below = 0, above = 0;
  distance = mass_tolerance * std::max(1.0, masses.sum());
  for (std::size_t i = 0; i < part.masses.size(); ++i) {
    const int number = geometry_.linkage.counterweights[i].mass_number;
    if (number < 0 || part.masses[i].is_left_out()) continue;
    const std::vector<double>& sizes = sizes_[static_cast<std::size_t>(number)];
    const double mass = masses[static_cast<Eigen::Index>(i)];
    const auto next = std::upper_bound(sizes.begin(), sizes.end(), mass);
    if (next == sizes.begin() || next == sizes.end()) continue;
    const double own = std::min(*next - mass, mass - *std::prev(next));
    if (own <= distance) continue;
    distance = own;
    chosen = static_cast<int>(i);
    below = *std::prev(next);
    above = *next;
  }
  if (chosen < 0) return {};
  std::vector<DesignPart> parts(2, part);
  parts[0].masses[static_cast<std::size_t>(chosen)].upper = below;
  parts[1].masses[static_cast<std::size_t>(chosen)].lower = above;
  const double mass = masses[chosen];
  if (mass - below < above - mass) std::swap(parts[0], parts[1]);
  return parts;
}

VectorX DiscreteDomain::round_lengths(const DesignPart& part, VectorX lengths) const {
  for (const int length : lengths_) {
    const std::vector<double>& sizes = sizes_[static_cast<std::size_t>(length)];
    if (sizes.empty()) continue;
    lengths[length] = std::clamp(nearest_size(sizes, lengths[length]), part.box.lower[length], part.box.upper[length]);
  }
  return lengths;
}

double DiscreteDomain::step_length(int length, double from, double step) const {
  const std::vector<double>& sizes = sizes_[static_cast<std::size_t>(length)];
  if (sizes.empty()) return from + step;
  const double target = nearest_size(sizes, from + step);
  if (target != from) return target;
  if (step > 0) {
    const auto above = std::upper_bound(sizes.begin(), sizes.end(), from);
    return above == sizes.end() ? from : *above;
  }
  const auto same = std::lower_bound(sizes.begin(), sizes.end(), from);
  return same == sizes.begin() ? from : *std::prev(same);
}

bool DiscreteDomain::complete(VectorX& x) const {
  double mass = 0;
  for (const FreeCounterweight& counterweight : geometry_.linkage.counterweights)
    if (counterweight.mass_number >= 0) mass += x[counterweight.mass_number];
  std::vector<int> kept(groups_.size(), 0);
  std::vector<bool> is_present(static_cast<std::size_t>(x.size()), true);
  const VectorX start = space_.start_values();
  for (const Element& element : elements_) {
    double amount = 0;
    for (const int i : element.counterweights)
      amount += x[geometry_.linkage.counterweights[static_cast<std::size_t>(i)].mass_number];
    for (const int length : element.lengths) amount = std::max(amount, std::abs(x[length]));
    if (amount > mass_tolerance * std::max(1.0, mass)) {
      ++kept[element.group];
      continue;
    }
    for (const int number : element.numbers) x[number] = 0;
    for (const int number : element.own_numbers) x[number] = start[number];
    for (const auto* numbers : {&element.numbers, &element.own_numbers})
      for (const int number : *numbers) is_present[static_cast<std::size_t>(number)] = false;
  }
  for (std::size_t g = 0; g < groups_.size(); ++g)
    if (kept[g] > groups_[g]) return false;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const FreeNumber& number = space_.start.free_numbers[static_cast<std::size_t>(i)];
    const double margin = size_tolerance * (std::abs(number.lower) + std::abs(number.upper));
    if (!(x[i] >= number.lower - margin && x[i] <= number.upper + margin)) return false;
    x[i] = std::clamp(x[i], number.lower, number.upper);
    if (number.discrete_values.empty()) continue;
    const double size = nearest_size(number.discrete_values, x[i]);
    // masses come from a linear program
    const double tolerance = std::max(margin, mass_tolerance * (number.upper - number.lower));
    if (std::abs(size - x[i]) > tolerance) return false;
    x[i] = size;
  }
  return has_different_sizes(x, is_present);
}

bool DiscreteDomain::has_different_sizes(const VectorX& x, const std::vector<bool>& is_present) const {
  for (const study::DifferentNumbers& different : space_.start.design.all_different) {
    double scale = 0;
    for (const int i : different.numbers)
      for (const double size : space_.start.free_numbers[static_cast<std::size_t>(i)].discrete_values)
        scale = std::max(scale, std::abs(size));
    std::vector<double> taken = different.taken;
    for (const int i : different.numbers) {
      if (!is_present[static_cast<std::size_t>(i)]) continue;
      if (study::is_taken(taken, x[i], scale)) return false;
      taken.push_back(x[i]);
    }
  }
  return true;
}

}  // namespace balance::certificate
