#include "balance/synthesis/formulas/parameter_sampler.hpp"

#include "balance/foundation/base/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace balance::formulas {

namespace {

constexpr double max_relative_change = 0.3;
/// Factor by which the change shrinks from draw to draw.
constexpr double shrink_factor = 0.8;

}  // namespace

ParameterSampler::ParameterSampler(Ring& ring, const ParametricModel& model)
    : ring_(ring), model_(model), max_zero_changes_(model.inputs().size(), max_relative_change) {
  std::map<SymbolKind, double> largest;
  for (const Symbol& symbol : ring.symbols()) {
    has_parameters_ = has_parameters_ || !symbol.source.is_constant();
    largest[symbol.kind] = std::max(largest[symbol.kind], std::abs(symbol.value));
  }
  for (const Angle& angle : ring.angles()) has_parameters_ = has_parameters_ || !angle.source.is_constant();
  const std::vector<double> before = model.evaluate_nodes(model.inputs());
  for (std::size_t i = 0; i < max_zero_changes_.size(); ++i) {
    if (model.inputs()[i] != 0) continue;
    std::vector<double> inputs = model.inputs();
    inputs[i] = 1;
    const std::vector<double> after = model.evaluate_nodes(inputs);
    for (const Symbol& symbol : ring.symbols()) {
      const double unit = std::abs(ParametricModel::node_value(symbol.source, after) -
                                   ParametricModel::node_value(symbol.source, before));
      if (!std::isfinite(unit) || unit == 0 || largest[symbol.kind] == 0) continue;
      max_zero_changes_[i] = max_relative_change * largest[symbol.kind] / unit;
      break;
    }
  }
}

std::vector<double> ParameterSampler::draw(std::mt19937_64& random, int draws_before) const {
  const double shrinkage = elementary::pow(shrink_factor, draws_before);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<double> inputs = model_.inputs();
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const double x = shrinkage * uniform(random);
    inputs[i] = inputs[i] == 0 ? std::abs(x) * max_zero_changes_[i] : inputs[i] * (1 + max_relative_change * x);
  }
  return inputs;
}

ScopedSymbolValues::ScopedSymbolValues(Ring& ring, const std::vector<double>& nodes) : ring_(ring) {
  for (const Symbol& symbol : ring.symbols()) saved_symbols_.push_back(symbol.value);
  for (const Angle& angle : ring.angles()) saved_angles_.push_back(angle.value);
  for (std::size_t s = 0; s < saved_symbols_.size(); ++s)
    if (const Expression& source = ring.symbol(static_cast<int>(s)).source; !source.is_constant())
      ring.set_value(static_cast<int>(s), ParametricModel::node_value(source, nodes));
  for (std::size_t a = 0; a < saved_angles_.size(); ++a)
    if (const Expression& source = ring.angle(static_cast<int>(a)).source; !source.is_constant())
      ring.set_angle(static_cast<int>(a), ParametricModel::node_value(source, nodes));
}

ScopedSymbolValues::~ScopedSymbolValues() {
  for (std::size_t s = 0; s < saved_symbols_.size(); ++s) ring_.set_value(static_cast<int>(s), saved_symbols_[s]);
  for (std::size_t a = 0; a < saved_angles_.size(); ++a) ring_.set_angle(static_cast<int>(a), saved_angles_[a]);
}

}  // namespace balance::formulas
