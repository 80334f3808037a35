#include "balance/design/parameter_map.hpp"

#include "balance/base/error.hpp"
#include "balance/design/fit.hpp"

#include <limits>

namespace balance::design {

FeatureMap::FeatureMap(const VariableScaling& box, const DesignProblem& problem, const VariableClassification& survey)
    : box_(box),
      problem_(problem),
      loose_(survey.loose_springs),
      features_(static_cast<int>(survey.base_features.size())) {
  polynomial_ = fit_feature_polynomials(survey, [this](const VectorX& u) { return evaluate_from_mechanism(u); });
}

VectorX FeatureMap::evaluate_from_mechanism(const VectorX& u) const {
  try {
    return design::compute_features(problem_.build_mechanism(box_.to_variables(u)), loose_);
  } catch (const SpecError&) {
    return VectorX::Constant(features_, std::numeric_limits<double>::quiet_NaN());
  }
}

void FeatureMap::evaluate(const VectorX& u, VectorX& values, MatrixX* jacobian) const {
  if (polynomial_) {
    polynomial_->evaluate(u, values, jacobian);
    return;
  }
  values = evaluate_from_mechanism(u);
  if (jacobian != nullptr)
    *jacobian =
        central_difference_jacobian([this](const VectorX& v) { return evaluate_from_mechanism(v); }, u, features_);
}

}  // namespace balance::design
