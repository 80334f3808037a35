#include "balance/mechanics/model/variable_function.hpp"

#include "balance/foundation/base/dual.hpp"
#include "balance/foundation/expression/expression_evaluation.hpp"

#include <array>

namespace balance::model {

ValueAndRate evaluate(const VariableFunction& function, std::span<const double> variables,
                      std::span<const double> rates) {
  std::vector<Dual<1>> inputs;
  for (std::size_t k = 0; k < variables.size(); ++k) {
    inputs.emplace_back(variables[k]);
    inputs.back().d[0] = rates[k];
  }
  inputs.insert(inputs.end(), function.parameters.begin(), function.parameters.end());
  const std::vector<Dual<1>> values =
      expression::evaluate(*function.graph, inputs, expression::ScalarAlgebra<Dual<1>>{});
  const Dual<1>& result = values[static_cast<std::size_t>(function.node)];
  return {result.value, result.d[0]};
}

ValueAndRate evaluate_at_time(const VariableFunction& function, double time) {
  if (!function) return {};
  return evaluate(function, std::array{time}, std::array{1.0});
}

}  // namespace balance::model
