#include "balance/formulas/other_numbers.hpp"

#include "balance/base/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace balance::formulas {

namespace {

constexpr double max_change = 0.3;
/// What remains of the change after a draw at which nothing could be compared.
constexpr double shrink_factor = 0.8;

}  // namespace

OtherNumbers::OtherNumbers(const Ring& ring, const NumberModel& model)
    : model_(model), zero_reach_(model.inputs().size(), max_change) {
  std::map<SymbolKind, double> largest;
  for (const Symbol& symbol : ring.symbols()) {
    exist_ = exist_ || !symbol.source.is_constant();
    largest[symbol.kind] = std::max(largest[symbol.kind], std::abs(symbol.value));
  }
  for (const Angle& angle : ring.angles()) exist_ = exist_ || !angle.source.is_constant();
  const std::vector<double> before = model.nodes_at(model.inputs());
  for (std::size_t i = 0; i < zero_reach_.size(); ++i) {
    if (model.inputs()[i] != 0) continue;
    std::vector<double> inputs = model.inputs();
    inputs[i] = 1;
    const std::vector<double> after = model.nodes_at(inputs);
    for (const Symbol& symbol : ring.symbols()) {
      const double unit =
          std::abs(NumberModel::value(symbol.source, after) - NumberModel::value(symbol.source, before));
      if (!std::isfinite(unit) || unit == 0 || largest[symbol.kind] == 0) continue;
      zero_reach_[i] = max_change * largest[symbol.kind] / unit;
      break;
    }
  }
}

std::vector<double> OtherNumbers::draw(std::mt19937_64& random, int draws_before) const {
  const double share = elementary::pow(shrink_factor, draws_before);
  std::uniform_real_distribution<double> any(-1, 1);
  std::vector<double> inputs = model_.inputs();
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const double x = share * any(random);
    inputs[i] = inputs[i] == 0 ? std::abs(x) * zero_reach_[i] : inputs[i] * (1 + max_change * x);
  }
  return inputs;
}

ValuesElsewhere::ValuesElsewhere(Ring& ring, const std::vector<double>& nodes) : ring_(ring) {
  for (const Symbol& symbol : ring.symbols()) symbols_.push_back(symbol.value);
  for (const Angle& angle : ring.angles()) angles_.push_back(angle.value);
  for (std::size_t s = 0; s < symbols_.size(); ++s)
    if (const Expression& source = ring.symbol(static_cast<int>(s)).source; !source.is_constant())
      ring.set_value(static_cast<int>(s), NumberModel::value(source, nodes));
  for (std::size_t a = 0; a < angles_.size(); ++a)
    if (const Expression& source = ring.angle(static_cast<int>(a)).source; !source.is_constant())
      ring.set_angle(static_cast<int>(a), NumberModel::value(source, nodes));
}

ValuesElsewhere::~ValuesElsewhere() {
  for (std::size_t s = 0; s < symbols_.size(); ++s) ring_.set_value(static_cast<int>(s), symbols_[s]);
  for (std::size_t a = 0; a < angles_.size(); ++a) ring_.set_angle(static_cast<int>(a), angles_[a]);
}

}  // namespace balance::formulas
